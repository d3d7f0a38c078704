#include "scheduling/record/summary_columns.hpp"
#include "scheduling/session/session.hpp"
#include "small_body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "tests/support/session_keys.hpp"

TEST_CASE("virtual clock: starts with nothing, fades in, accounts for everything") {
  SessionInput input = small_input();
  SessionOptions options = virtual_options(2);
  options.workers.count = 4;
  const SessionResult r = run_session(input, options);
  REQUIRE(r.frames.size() == 2000);
  CHECK(r.frames.front().known == 0);
  CHECK(r.frames.front().label == Label::blank);
  CHECK(r.frames.front().force == Vec3::Zero());
  CHECK(r.frames.front().at == Vec3::Zero());
  CHECK(r.counts.start == 0);
  CHECK(r.counts.solved == 125);
  CHECK(r.counts.failed == 0);
  CHECK(r.states.size() == 125);
  expect_no_state_twice(r);
  std::size_t over = 0;
  for (std::size_t k = 1; k < r.frames.size(); ++k) {
    REQUIRE(r.frames[k].known >= r.frames[k - 1].known);
    over += r.frames[k].step.change > r.frames[k].step.bound;
    // The change of the force is the sum of the changes by the motion and by the switch.
    REQUIRE((r.frames[k].force - r.frames[k - 1].force).norm() <=
            r.frames[k].step.change + r.frames[k].step.motion_change + 1e-12);
  }
  CHECK(over == 0);
  for (const DispatchRecord& d : r.dispatch) {
    CHECK(d.started <= d.finished);
    if (d.status == DispatchStatus::solved)
      CHECK(d.finished - d.started == Approx(d.at.isZero(0) ? 0.0025 : 0.01).margin(2e-9));
    CHECK(d.known == d.finished);
    CHECK(d.worker >= 0);
    CHECK(d.worker < 4);
    CHECK(d.parent < static_cast<std::int64_t>(d.id));
  }
  // Rest after 2.5 ms, then four workers of 10 ms each: 400 states a second.
  CHECK(r.frames[105].known == 41);
  // Once the box is full, places inside it are safe, and their errors are well below the JND.
  const FrameRecord& late = r.frames.back();
  CHECK(late.known == 125);
  double worst = 0;
  for (const FrameRecord& f : r.frames)
    if (f.t > 1 && std::isfinite(f.judged.approximation) && input.touched.space.box.contains(f.at)) {
      CHECK(f.label == Label::safe);
      worst = std::max(worst, f.judged.approximation);
    }
  CHECK(worst > 0);
  CHECK(worst < 0.02);

  const SessionSummary summary = summarise(r, input, options);
  CHECK(summary.states.solved == 125);
  CHECK(summary.states.used + summary.states.wasted == 125);
  CHECK(summary.switching.frames_over_jnd == 0);
  CHECK(summary.switching.count == r.switches.size());
  CHECK(std::isnan(summary.deadline.cost_us.p50));
  double shares = 0;
  for (const Label label : all_labels) shares += summary.time_in[label];
  CHECK(shares == Approx(1));
  CHECK(summary.error.samples.samples > 40);
  CHECK(summary.load > 0);
}

TEST_CASE(
    "the summary of a plan knows the force limit, the frames asked for, and how the motion was foreseen") {
  const SessionInput input = small_input(Law::linear);
  SessionOptions options = virtual_options(0.2);
  options.safety.force_limit = 3;
  const SessionPlan plan = make_plan(input, options);
  PredictorScores scores(options.clock.frame);
  std::atomic<bool> stop = false;
  const SessionResult whole = run_session(plan, {.each_position = [&](const Vec3& at) { scores.add(at); }});
  SessionSummary summary = summarise(whole, plan);
  summary.motion.prediction = scores.report();
  CHECK(summary.safety.force_limit == 3);
  CHECK(summary.run.frames_asked == 200);
  CHECK(summary.settings.spacing == input.touched.space.spacing);
  CHECK_FALSE(summary.run.interrupted);
  REQUIRE(summary.motion.prediction.size() == predictor_names().size() - 1);  // without `network`
  CHECK(summary.motion.prediction.front().by_horizon.front().p95 < 0.01);     // [m]

  SessionPlan stopped = make_plan(input, options);
  stopped.options.stop.interrupted = &stop;
  stop = true;
  const SessionSummary part = summarise(run_session(stopped), stopped);
  CHECK(part.run.interrupted);
  CHECK(part.run.frames < part.run.frames_asked);
}

TEST_CASE("summary: every key of the contract") {
  const SessionInput input = small_input();
  const SessionOptions options = virtual_options(0.2);
  std::set<std::string> names;
  for (const Column& column : summary_columns(summarise(run_session(input, options), input, options)))
    CHECK(names.insert(column.name).second);
  CHECK(names.contains("error.by_label.safe.p95"));
  for (const std::string& key : session_summary_keys) {
    CAPTURE(key);
    CHECK(names.contains(key));
  }
}

TEST_CASE("every policy, every switch rule, preemption and many workers run to the end") {
  for (const std::string& policy : policy_names()) {
    for (const int workers : {1, 40}) {
      CAPTURE(policy, workers);
      SessionOptions options = virtual_options(0.6);
      options.planning.policy = policy;
      options.workers.count = workers;
      options.workers.cost = ConstantCost{0.05};
      const SessionResult r = run_session(small_input(Law::linear), options);
      CHECK(r.frames.size() == 600);
      expect_no_state_twice(r);
      CHECK(r.states.size() == r.counts.solved);
      CHECK(r.states.size() > 5);
    }
  }
  for (const SwitchRule rule : {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none}) {
    SessionOptions options = virtual_options(0.6);
    options.switching.rule = rule;
    const SessionResult r = run_session(small_input(), options);
    std::size_t over = 0;
    for (const FrameRecord& f : r.frames) over += f.step.change > f.step.bound;
    if (rule != SwitchRule::none) CHECK(over == 0);
    if (rule == SwitchRule::none) CHECK(over > 0);
  }
  for (const Kernel kernel : {Kernel::linear, Kernel::cubic, Kernel::quintic}) {
    CAPTURE(name(kernel));
    SessionOptions options = virtual_options(0.6);
    options.model.fit = {.kernel = kernel, .data = Data::force, .neighbours = 100};
    options.model.first_guess = true;
    const SessionResult r = run_session(small_input(), options);
    CHECK(r.frames.size() == 600);
    CHECK(r.frames.back().force.norm() > 0);
  }
}

TEST_CASE("a linear body needs three solves: states are exact multiples") {
  const SessionResult r = run_session(small_input(Law::linear), virtual_options(0.8));
  REQUIRE(r.states.size() > 20);
  const Mat3 k = r.states.front().stiffness;
  CHECK((k - k.transpose()).norm() < 1e-9 * k.norm());
  Solver solver(test::small_body(Law::linear));
  for (const State& state : r.states) {
    CHECK((state.force + k * state.at).norm() <= 1e-12);
    if (state.at.norm() == 0) continue;
    const State tight = solver.reference(state.at, 0.006).state;
    CHECK((state.force - tight.force).norm() < 1e-8 * tight.force.norm());
    CHECK(state.energy == Approx(tight.energy).epsilon(1e-8));
  }
}

TEST_CASE("real clock: renders, solves and reports") {
  SessionInput input = small_input();
  SessionOptions options = virtual_options(2);
  options.clock.kind = Clock::real;
  options.workers.count = 2;
  const SessionResult r = run_session(input, options);
  REQUIRE(r.frames.size() + r.loop.skipped >= 2000);  // a loaded machine comes late
  CHECK(r.solver.workers == 2);
  CHECK(r.states.size() > 0);
  CHECK(r.counts.solved == r.states.size());
  expect_no_state_twice(r);
  std::size_t over = 0, taken = 0;
  for (const FrameRecord& f : r.frames) {
    REQUIRE(f.sent.allFinite());
    REQUIRE(std::isfinite(f.timing.cost_us));
    REQUIRE(std::isfinite(f.timing.lateness_us));
    over += f.step.change > f.step.bound;
    taken += f.step.took_model;
  }
  CHECK(over == 0);
  CHECK(taken == r.switches.size());
  CHECK(taken > 0);
  for (const State& state : r.states) {
    CHECK(state.usable());
    CHECK(state.has_stiffness());
  }
  const SessionSummary summary = summarise(r, input, options);
  CHECK(summary.settings.clock == Clock::real);
  CHECK(std::isfinite(summary.deadline.cost_us.p50));
  if (!r.run.realtime_priority) CHECK(!r.notes.empty());  // a note reports it
}
