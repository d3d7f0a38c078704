// What a session does on both contacts: a place that is grasped, and a body that is touched anywhere.
#include <mutex>

#include "geometry/states/state_file.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/session/input_replay.hpp"
#include "small_body.hpp"
#include "touched_liver.hpp"

namespace {

struct Contacted {
  SessionInput input;
  SessionOptions options;
};

// anywhere: on the liver; else on a small linear body with one place.
Contacted contacted(bool anywhere) {
  if (anywhere) return {test::liver(), test::options_for(PathName::palpation, 0.012, 2.5)};
  return {small_input(), virtual_options(2)};
}

// The liver's session where many states are wanted.
Contacted demanding(bool anywhere) {
  Contacted made = contacted(anywhere);
  if (anywhere) {
    const SessionInput strict = test::liver_with([](TouchTask& task) { task.tolerance = 0.002; });
    made.input.touched.anywhere = strict.touched.anywhere;
  }
  return made;
}

struct Seen {
  std::mutex mutex;
  double longest = 0, solve = 0;  // horizon, expected solve [s]
  std::size_t predictions = 0, surprises = 0;
};

// Nearest first, but not a number for the first candidate of each step; notes what it was shown.
struct Watching final : Policy {
  explicit Watching(std::shared_ptr<Seen> notes, bool future = false)
      : seen(std::move(notes)), truth(future) {}
  std::string_view name() const override { return "watching"; }
  bool reads_regions() const override { return false; }
  bool reads_surprises() const override { return true; }
  bool reads_future() const override { return truth; }
  void look(const PlannerView& view) override {
    const std::lock_guard lock(seen->mutex);
    seen->longest = std::max(seen->longest, view.predicted.back().horizon);
    seen->predictions = std::max(seen->predictions, view.predicted.size());
    seen->solve = std::max(seen->solve, view.solve_seconds);
    std::size_t known = 0;
    for (const float s : view.surprises) known += std::isfinite(s);
    seen->surprises = std::max(seen->surprises, known);
  }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    return 1 / (0.001 + (candidate.at - view.hip.at).norm());
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                  std::span<double> out) const override {
    for (std::size_t i = 0; i < candidates.size(); ++i) out[i] = priority(candidates[i], view);
    if (candidates.size() > 1) out[0] = std::numeric_limits<double>::quiet_NaN();
  }
  std::shared_ptr<Seen> seen;
  bool truth;
};

struct Failing final : Policy {
  std::string_view name() const override { return "failing"; }
  bool reads_regions() const override { return false; }
  double priority(const Candidate&, const PlannerView&) const override { return 1; }
  void look(const PlannerView&) override {
    if (++looks > 1) throw std::runtime_error("a policy failed");
  }
  int looks = 0;
};

}  // namespace

TEST_CASE("a policy is shown the same on both contacts; what is not a number never wins", "[contacts]") {
  const bool anywhere = GENERATE(false, true);
  CAPTURE(anywhere);
  Contacted made = demanding(anywhere);
  const auto seen = std::make_shared<Seen>();
  const bool future = GENERATE(false, true);
  made.input.parts.policy = std::make_shared<Watching>(seen, future);
  made.options.workers.latency = 0.02;
  const SessionResult run = run_session(made.input, made.options);
  CHECK(run.failures.empty());
  CHECK(seen->predictions == (future ? 25 : 9));
  CHECK(seen->solve >= 0.05);  // a solve of 10 ms and its two messages
  CHECK(seen->surprises > 0);
  for (const DispatchRecord& d : run.dispatch) CHECK_FALSE(d.choice.priority < 0);
  bool said = false;
  for (const std::string& note : run.notes) said |= note.find("not finite numbers") != std::string::npos;
  CHECK(said);
}

TEST_CASE("a cancelled solve ends after its start, also with latency, and its work counts", "[contacts]") {
  const bool anywhere = GENERATE(false, true);
  CAPTURE(anywhere);
  Contacted made = demanding(anywhere);
  made.options.workers.latency = 0.01;
  made.options.workers.cost = ConstantCost{0.2};
  const SessionResult run = run_session(made.input, made.options);
  for (const DispatchRecord& d : run.dispatch)
    if (std::isfinite(d.finished) && std::isfinite(d.started)) CHECK(d.finished >= d.started);
}

TEST_CASE("a failing planner of a real session loses nothing of the run", "[contacts]") {
  const bool anywhere = GENERATE(false, true);
  CAPTURE(anywhere);
  Contacted made = contacted(anywhere);
  made.options.clock.kind = Clock::real;
  made.options.clock.seconds = 1.5;
  made.input.parts.policy = std::make_shared<Failing>();
  const SessionResult run = run_session(made.input, made.options);
  REQUIRE(run.failures.size() == 1);
  CHECK_THAT(run.failures[0], Contains("a policy failed"));
  REQUIRE_FALSE(run.frames.empty());
  CHECK(run.frames.back().sent.isZero(0));
}

TEST_CASE("a run is rendered again bit by bit from its inputs", "[contacts]") {
  const bool anywhere = GENERATE(false, true);
  CAPTURE(anywhere);
  const TemporaryFolder folder;
  const Contacted made = demanding(anywhere);
  SessionPlan plan = with_inputs_file(make_plan(made.input, made.options), folder.path() / "inputs", "test");
  const SessionResult run = run_session(plan);
  const auto touched = [&] { return made.input.touched; };
  const ReplayReport again = replay_inputs(folder.path() / "inputs", "test", {},
                                           anywhere ? touched : std::function<TouchedBody()>());
  CHECK(again.frames == run.frames.size());
  CHECK(again.equal == again.frames);
  CHECK(again.states == run.states.size());
  CHECK(again.whole);
  if (!anywhere) return;
  CHECK_THROWS_WITH(replay_inputs(folder.path() / "inputs"), Contains("--scene"));
  const SessionInput other = test::liver_with([](TouchTask& task) { task.friction = 0.4; });
  CHECK_THROWS_WITH(replay_inputs(folder.path() / "inputs", "test", {}, [&] { return other.touched; }),
                    Contains("friction"));
}

TEST_CASE("states arrive at given times, and foreign ones are rendered alone", "[contacts]") {
  const bool anywhere = GENERATE(false, true);
  CAPTURE(anywhere);
  const Contacted made = demanding(anywhere);
  const SessionResult solved = run_session(made.input, made.options);
  REQUIRE(solved.states.size() > 2);
  SessionPlan plan = make_plan(made.input, made.options);
  const SessionResult foreign = run_session(with_foreign(plan, solved.states));
  CHECK(foreign.dispatch.empty());
  CHECK(foreign.counts.start == solved.states.size());
  for (const FrameRecord& frame : foreign.frames) CHECK_FALSE(std::isfinite(frame.judged.error));
  plan.arrivals.given = true;
  for (const State& state : solved.states)
    if (state.at.norm() > 0)
      plan.arrivals.list.push_back(
          {.t = 0.2,
           .at = state.at,
           .site = anywhere ? test::liver_task().field->rest().map().nearest(state.site) : SurfacePlace()});
  const SessionResult arrived = run_session(plan);
  REQUIRE_FALSE(arrived.dispatch.empty());
  for (const DispatchRecord& d : arrived.dispatch) CHECK(d.status == DispatchStatus::arrived);
  CHECK(arrived.counts.solved == plan.arrivals.list.size());
}
