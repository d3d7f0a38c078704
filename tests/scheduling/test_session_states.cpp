#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "scheduling/session/session.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

TEST_CASE("states of the start are used, kept and not solved again") {
  const TemporaryFolder folder;
  SessionInput input = small_input();
  input.files.states = folder / "a.states";
  const SessionResult first = run_session(input, virtual_options(0.3));
  const std::size_t solved = first.states.size();
  REQUIRE(solved > 10);
  CHECK(StateFile::open_read_only(folder / "a.states").read_all().size() == solved);

  input.known = StateFile::open_read_only(folder / "a.states").read_all();
  const SessionResult second = run_session(input, virtual_options(0.3));
  CHECK(second.counts.start == solved);
  CHECK(second.frames.front().known == solved);
  CHECK(second.states.size() == solved + second.counts.solved);
  const auto all = StateFile::open_read_only(folder / "a.states").read_all();
  CHECK(all.size() == second.states.size());
  std::set<std::tuple<double, double, double>> places;
  for (const State& state : all) CHECK(places.insert({state.at.x(), state.at.y(), state.at.z()}).second);
}

// Run by the next test in a process of its own, which is killed.
TEST_CASE("session that is killed", "[.]") {
  SessionInput input = small_input();
  input.touched.space.spacing = 0.0015;  // thousands of states: far from done when it is killed
  input.files.states = std::getenv("FOREFEEL_TEST_STATES");
  SessionOptions options = virtual_options(600);
  options.clock.kind = Clock::real;
  run_session(input, options);
}

TEST_CASE("kill -9 loses nothing that was committed") {
  const TemporaryFolder folder;
  const fs::path file = folder / "a.states";
  const pid_t child = fork();
  if (child == 0) {
    setenv("FOREFEEL_TEST_STATES", file.c_str(), 1);
    freopen("/dev/null", "w", stdout);
    execl("/proc/self/exe", "test_scheduling", "session that is killed", static_cast<char*>(nullptr));
    _exit(127);
  }
  std::size_t seen = 0;
  while (seen < 20 && waitpid(child, nullptr, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (!fs::exists(file)) continue;
    try {
      seen = StateFile::open_read_only(file).size();
    } catch (const InputError&) {  // not made yet
    }
  }
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFSIGNALED(status));
  REQUIRE(seen >= 20);
  const auto states = StateFile::open_read_only(file).read_all();
  CHECK(states.size() >= seen);
  for (const State& state : states) {
    CHECK(state.usable());
    CHECK(state.force.allFinite());
  }
  SessionInput input = small_input();
  input.files.states = file;
  input.known = states;
  CHECK(run_session(input, virtual_options(0.05)).counts.start == states.size());
}

TEST_CASE(
    "two runs of one body share the cache of references: one writes, the other reads, the results are the "
    "same") {
  const TemporaryFolder folder;
  SessionInput input = small_input();
  input.files.cache = folder / "cache";
  const SessionOptions options = virtual_options(0.5);
  const SessionResult first = run_session(input, options);
  const ReferenceService writing(reference_options(input), 1);
  REQUIRE_FALSE(writing.note());
  const SessionResult second = run_session(input, options);
  const auto only_read = [](const std::string& note) { return note.find("only read") != std::string::npos; };
  CHECK(std::ranges::any_of(second.notes, only_read));
  CHECK(std::ranges::none_of(first.notes, only_read));
  REQUIRE(second.frames.size() == first.frames.size());
  for (std::size_t k = 0; k < first.frames.size(); ++k)
    REQUIRE(second.frames[k].force == first.frames[k].force);
}
