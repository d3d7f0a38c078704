// A worker that returns impossible states: a force 1000 times too large, the stiffness of another body, NaN.

#include "scheduling/record/summary.hpp"
#include "scheduling/session/planner.hpp"
#include "scheduling/session/plausible.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

State spring(const Vec3& x, double strength = 1) {
  State state;
  state.at = x;
  state.force = -strength * 100 * x;
  state.stiffness = strength * 100 * Mat3::Identity();
  state.solve.status = SolveStatus::converged;
  return state;
}

// One worker; its answer comes when the test asks for it.
struct OneWorker final : Generator {
  std::optional<Job> job;
  int workers() const override { return 1; }
  void dispatch(int, Job given) override { job = std::move(given); }
  void cancel(int) override {}
  JobResult answer(const State& state) {
    JobResult result{.dispatch = job->dispatch,
                     .worker = 0,
                     .started = 0,
                     .finished = 0.01,
                     .state = state,
                     .equilibrium = nullptr};
    job.reset();
    return result;
  }
};

struct Bench {
  SessionInput input = small_input();
  SessionPlan plan = make_plan(input, virtual_options());
  OneWorker worker;
  std::vector<State> told;
  Planner planner{planner_setup(plan), worker, {.on_state = [this](const State& s) { told.push_back(s); }}};
  int k = 0;

  void solve(double strength) {  // the next state
    const double now = 0.01 * ++k;
    planner.observe({.t = now, .at = Vec3::Zero(), .velocity = Vec3::Zero()});
    planner.plan(now);
    REQUIRE(worker.job.has_value());
    planner.receive(worker.answer(spring(worker.job->at, strength)), now);
  }
};

}  // namespace

TEST_CASE("a state that known ones beside it contradict is set aside, and the session goes on") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double wrong : {1000.0, nan}) {
    CAPTURE(wrong);
    Bench b;
    for (int i = 0; i < 5; ++i) b.solve(1);
    CHECK(b.planner.space().size() == 5);
    b.solve(wrong);
    CHECK(b.planner.space().size() == 5);
    CHECK(b.planner.failed() == 1);
    CHECK_FALSE(b.told.back().usable());  // nor does a later session begin with it
    b.solve(10);                          // stiffer than its neighbours, as a body may be
    CHECK(b.planner.space().size() == 6);
    CHECK(b.planner.failed() == 1);
    CHECK(b.planner.solved() == 6);
  }
}

TEST_CASE("a state that arrives without a solve is judged like a solved one") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double wrong : {1000.0, nan}) {
    CAPTURE(wrong);
    Bench b;
    b.planner.arrive(spring(Vec3::Zero()), 0);
    b.planner.arrive(spring(Vec3(0.006, 0, 0)), 0.1);
    b.planner.arrive(spring(Vec3(0, 0.006, 0), wrong), 0.2);
    CHECK(b.planner.space().size() == 2);
    CHECK(b.planner.failed() == 1);
    CHECK_FALSE(b.told.back().usable());
    b.planner.arrive(spring(Vec3(0, 0, 0.006), 10), 0.3);
    CHECK(b.planner.space().size() == 3);
  }
}

TEST_CASE("arrivals: a state of another unit is set aside, counted and said") {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.csv") << "t,x,y,z\n0.01,0,0,0\n0.05,0.006,0,0\n0.1,0,0.006,0\n0.15,0,0,0.006\n";
  SessionOptions options = virtual_options(0.3);
  options.planning.arrivals = folder / "a.csv";
  SessionInput input = small_input();
  input.references = std::make_shared<ReferenceService>(reference_options(input), 1);
  State wrong = input.references->get(Vec3(0, 0.006, 0));
  wrong.force *= 1000;
  wrong.stiffness *= 1000;
  SessionInput poisoned = small_input();
  ReferenceOptions references = reference_options(poisoned);
  references.cache_folder = folder / "cache";
  ReferenceCache(references, false).keep(wrong);
  poisoned.references = std::make_shared<ReferenceService>(references, 1);
  for (const Clock clock : {Clock::virtual_time, Clock::real}) {
    options.clock.kind = clock;
    if (clock == Clock::real) options.clock.seconds = 3;
    CHECK(run_session(input, options).states.size() == 4);
    const SessionPlan plan = make_plan(poisoned, options);
    const SessionResult result = run_session(plan);
    CHECK(result.states.size() == 3);
    const SessionSummary summary = summarise(result, plan);
    CHECK(summary.loop.faults.states_set_aside == 1);
    CHECK(summary.states.failed == 1);
    CHECK(std::ranges::any_of(result.notes, [](const std::string& note) {
      return note.find("solve at 0, 0.006, 0 m failed: set aside") != std::string::npos;
    }));
  }
}

TEST_CASE("far too strong: the bound, and what is said without neighbours") {
  StateSpaceOptions options;
  options.spacing = 0.006;
  options.box = {Vec3::Constant(-0.024), Vec3::Constant(0.024)};
  StateSpace space(options);
  const Vec3 x(0.006, 0, 0);
  CHECK_FALSE(is_far_too_strong(spring(x, 1000), space));  // nothing is known yet
  space.insert(spring(Vec3::Zero()));
  CHECK(is_far_too_strong(spring(x, 1000), space));
  CHECK_FALSE(is_far_too_strong(spring(x, 90), space));
  CHECK_FALSE(is_far_too_strong(spring(Vec3(0.013, 0, 0), 1000), space));  // farther than two spacings
  State no_stiffness = spring(x, 90);
  no_stiffness.stiffness.setConstant(unknown);
  CHECK_FALSE(is_far_too_strong(no_stiffness, space));
  no_stiffness.force *= 1e4;
  CHECK(is_far_too_strong(no_stiffness, space));
}

TEST_CASE("far too strong: a first state is compared with the body itself") {
  StateSpaceOptions options;
  options.spacing = 0.006;
  options.box = {Vec3::Constant(-0.024), Vec3::Constant(0.024)};
  const StateSpace nothing(options);
  const Mat3 stiffest = 200 * Mat3::Identity();  // twice the spring
  const Vec3 rest = Vec3::Zero(), away(0.02, 0, 0);
  CHECK_FALSE(is_far_too_strong(spring(rest), nothing, stiffest));
  CHECK_FALSE(is_far_too_strong(spring(rest, 5.9), nothing, stiffest));
  CHECK(is_far_too_strong(spring(rest, 6.1), nothing, stiffest));
  CHECK(is_far_too_strong(spring(rest, 1000), nothing, stiffest));
  State pushed = spring(rest);
  pushed.force =
      Vec3(3.5, 0, 0);  // what 3 times the bound does over 6 mm is 2.1 N, by the Frobenius norm 6.2 N
  CHECK_FALSE(is_far_too_strong(pushed, nothing, stiffest));
  pushed.force = Vec3(6.3, 0, 0);
  CHECK(is_far_too_strong(pushed, nothing, stiffest));
  CHECK_FALSE(is_far_too_strong(spring(away, 190), nothing, stiffest));  // a body stiffens
  CHECK(is_far_too_strong(spring(away, 1000), nothing, stiffest));
}
