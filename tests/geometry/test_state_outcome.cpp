// Equilibria with inverted elements: an outcome of their own in state files.

#include <sqlite3.h>

#include "geometry/states/state_file.hpp"
#include "geometry/states/state_outcome.hpp"
#include "tests/geometry/state_samples.hpp"
#include "tests/support/test.hpp"

namespace {

State plain(double min_jacobian) {
  State s;
  s.at = {0.001, 0.002, 0.003};
  s.force = {1, 2, 3};
  s.stiffness = 100 * Mat3::Identity();
  s.energy = 0.5;
  s.solve.status = SolveStatus::converged;
  s.solve.iterations = 3;
  s.solve.residual = 1e-11;
  s.solve.seconds = 0.004;
  s.solve.min_jacobian = min_jacobian;
  s.solve.parent = Vec3::Zero();
  return s;
}

std::string query(const fs::path& file, const std::string& sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  std::string seen;
  const auto row = [](void* out, int n, char** text, char**) {
    for (int i = 0; i < n; ++i)
      *static_cast<std::string*>(out) += std::string(text[i] ? text[i] : "NULL") + " ";
    return 0;
  };
  CHECK(sqlite3_exec(database, sql.c_str(), row, &seen, nullptr) == SQLITE_OK);
  sqlite3_close(database);
  return seen;
}

}  // namespace

TEST_CASE("an equilibrium with an inverted element has an outcome of its own, in memory and in the file") {
  CHECK(outcome(plain(0.25)) == SolveStatus::converged);
  CHECK(outcome(plain(unknown)) == SolveStatus::converged);  // not known to be inverted
  CHECK(outcome(plain(0)) == SolveStatus::inverted);
  State measured = plain(-1);
  measured.solve.status = SolveStatus::measured;
  CHECK(outcome(measured) == SolveStatus::measured);

  const TemporaryFolder folder;
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{plain(0.25), plain(-0.25)});
  CHECK(query(folder / "s.states", "SELECT status FROM states ORDER BY id") == "converged inverted ");
  const StateFile file = StateFile::open_read_only(folder / "s.states");
  const std::vector<State> again = file.read_all();
  CHECK(file.damaged() == 0);
  REQUIRE(again.size() == 2);
  CHECK(same(again[1], plain(-0.25)));
  CHECK(again[1].usable());
  CHECK(has_inverted_elements(again[1]));
}

TEST_CASE("older files, which call such a state converged, read as before") {
  const TemporaryFolder folder;
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{plain(-0.25)});
  // The checksum that earlier versions wrote for this row.
  query(folder / "s.states", "UPDATE states SET status = 'converged', checksum = -5548587779215594796");
  const StateFile file = StateFile::open_read_only(folder / "s.states");
  const std::vector<State> again = file.read_all();
  CHECK(file.damaged() == 0);
  REQUIRE(again.size() == 1);
  CHECK(same(again[0], plain(-0.25)));
  CHECK(outcome(again[0]) == SolveStatus::inverted);
}

TEST_CASE("a solve that failed among inverted elements has no force and stays unusable") {
  const TemporaryFolder folder;
  State failed = plain(-0.25);
  failed.solve.status = SolveStatus::inverted;
  failed.force = Vec3::Constant(unknown);
  StateFile::open_or_create(folder / "s.states", header()).append(std::vector{failed});
  const std::vector<State> again = StateFile::open_read_only(folder / "s.states").read_all();
  REQUIRE(again.size() == 1);
  CHECK(again[0].solve.status == SolveStatus::inverted);
  CHECK_FALSE(again[0].usable());
  CHECK_FALSE(has_inverted_elements(again[0]));
}
