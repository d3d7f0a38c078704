// Check solves in a state file.

#include "geometry/states/check_solves.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/test.hpp"

TEST_CASE("check solves are kept beside the states, and replaced as a whole") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "s.states";
  State a;
  a.at = {0.1, -1.0 / 3, 2e-9};
  a.force = {1.0 / 7, -2, 3};
  State failed = a;
  failed.solve.status = SolveStatus::diverged;
  {
    StateFile open =
        StateFile::open_or_create(file, {.identity = {}, .spacing = 0.006, .box = {}, .notes = {}});
    open.append(std::span(&a, 1));
    keep_checks(file, std::vector<State>{a, a, failed});
    keep_checks(file, std::vector<State>{a, failed});
  }
  const LoadedStates loaded = load_states(file);
  CHECK(loaded.states.size() == 1);
  const std::vector<State> checks = check_solves(loaded.header).states;
  REQUIRE(checks.size() == 1);
  CHECK(checks[0].at == a.at);
  CHECK(checks[0].force == a.force);
}

TEST_CASE("a check solve that is no six finite numbers is refused") {
  for (const char* text : {"1,2,3,4,5\n", "1,2,3,4,5,nan\n", "1,2,3,4,5,x\n", "1,2,3,4,5,1e200\n"}) {
    StateFileHeader header;
    header.notes["checks"] = text;
    CHECK_THROWS_AS(check_solves(header), InputError);
  }
  CHECK(check_solves({}).states.empty());
}
