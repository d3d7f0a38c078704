#include "run_logs.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"

TEST_CASE("arrivals: states are known when the file says") {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.csv")
      << "t,x,y,z\n0.1,0,0,0\n0.25,0.006,0,0\n0.25,0,0.006,0\n0.05,0,0,0.006\n9,0.012,0,0\n";
  SessionOptions options = virtual_options(0.5);
  options.planning.arrivals = folder / "a.csv";
  const SessionResult r = run_session(small_input(), options);
  const auto known = [&](double t) {
    return r.frames[static_cast<std::size_t>(std::lround(t * 1000))].known;
  };
  CHECK(known(0.049) == 0);
  CHECK(known(0.05) == 1);
  CHECK(known(0.099) == 1);
  CHECK(known(0.1) == 2);
  CHECK(known(0.249) == 2);
  CHECK(known(0.25) == 4);
  CHECK(r.frames.back().known == 4);
  REQUIRE(r.dispatch.size() == 4);
  CHECK(r.dispatch.front().status == DispatchStatus::arrived);
  CHECK(r.dispatch.front().at == Vec3(0, 0, 0.006));

  options.clock.kind = Clock::real;
  options.clock.seconds = 3;
  const SessionResult real = run_session(small_input(), options);
  CHECK(real.states.size() == 4);
  CHECK(real.dispatch.size() == 4);
}

TEST_CASE("replay: a recorded run gives the same forces again") {
  const TemporaryFolder folder;
  SessionOptions options = virtual_options(1);
  options.workers.cost = LogNormalCost{0.02, 0.5};
  options.workers.latency = 0.002;
  options.motion.device = PathMotion{.path = PathName::tour, .speed = 0.06, .tremor = 0.0001};
  prepare_run_folder(folder / "run");
  const SessionResult first = run_session(small_input(), options);
  write_run_files(folder / "run", first, options);
  options.motion.replay = folder / "run";
  options.motion.device = PathMotion{.path = PathName::press};
  const SessionResult second = run_session(small_input(), options);
  REQUIRE(second.frames.size() == first.frames.size());
  for (std::size_t k = 0; k < first.frames.size(); ++k) {
    REQUIRE(second.frames[k].at == first.frames[k].at);
    REQUIRE(second.frames[k].force == first.frames[k].force);
    REQUIRE(second.frames[k].known == first.frames[k].known);
    REQUIRE(second.frames[k].label == first.frames[k].label);
  }
  CHECK(second.switches.size() == first.switches.size());
}
