#include <deque>

#include "scheduling/session/planner.hpp"
#include "scheduling/session/session_plan.hpp"
#include "scheduling/session/session_setup.hpp"
#include "small_body.hpp"

namespace {

State spring(const Vec3& x) {
  State state;
  state.at = x;
  state.force = -100 * x;
  state.stiffness = 100 * Mat3::Identity();
  state.solve.status = SolveStatus::converged;
  return state;
}

// Keeps what it is given; the test decides when and how each job ends.
class ManualWorkers final : public Generator {
 public:
  explicit ManualWorkers(int count) : count_(count) {}
  int workers() const override { return count_; }
  void dispatch(int worker, Job job) override {
    REQUIRE(jobs.count(worker) == 0);  // only idle workers are given jobs
    jobs[worker] = std::move(job);
  }
  void cancel(int worker) override { cancelled.insert(worker); }
  JobResult end(int worker, double now, SolveStatus status = SolveStatus::converged, double took = 0.01) {
    JobResult result{.dispatch = jobs.at(worker).dispatch,
                     .worker = worker,
                     .started = now - took,
                     .finished = now,
                     .state = spring(jobs.at(worker).at),
                     .equilibrium = nullptr};
    result.state.solve.status = status;
    jobs.erase(worker);
    cancelled.erase(worker);
    return result;
  }
  std::map<int, Job> jobs;
  std::set<int> cancelled;

 private:
  int count_;
};

struct Bench {
  explicit Bench(SessionOptions chosen = virtual_options(), int workers = 3, double expected = 0.01)
      : options(std::move(chosen)),
        input(small_input()),
        plan(make_plan(input, options)),
        generator(workers),
        planner(planner_setup(plan), generator,
                {.on_state = [this](const State& s) { told.push_back(s); },
                 .future = {},
                 .expected_solve = expected}) {}
  SessionOptions options;
  SessionInput input;
  SessionPlan plan;
  ManualWorkers generator;
  LoopLink link;
  std::vector<State> told;
  Planner planner;
  ModelKeeper models{planner.space(), plan.model, link};
  void update(double now) { models.update(now, planner.hip().at); }
};

}  // namespace

TEST_CASE("planner: every lattice point is solved once, under every policy") {
  for (const std::string& policy : policy_names()) {
    CAPTURE(policy);
    SessionOptions options = virtual_options();
    options.planning.policy = policy;
    Bench b(options);
    std::set<std::uint64_t> solved;
    double now = 0;
    for (int round = 0; round < 200 && solved.size() < 125; ++round) {
      now += 0.004;
      b.planner.observe({.t = now,
                         .at = 0.012 * Vec3(std::sin(now), std::cos(3 * now), std::sin(2 * now)),
                         .velocity = {0.01, 0, 0}});
      b.planner.plan(now);
      while (!b.generator.jobs.empty()) {
        const int worker = b.generator.jobs.begin()->first;
        const bool cancel = b.generator.cancelled.count(worker) > 0;
        const Vec3 x = b.generator.jobs.begin()->second.at;
        b.planner.receive(
            b.generator.end(worker, now, cancel ? SolveStatus::cancelled : SolveStatus::converged), now);
        if (cancel) continue;
        std::uint64_t key = 0;
        for (int i = 0; i < 3; ++i)
          key = 100 * key + static_cast<std::uint64_t>(std::lround(x[i] / 0.006) + 10);
        REQUIRE(solved.insert(key).second);
      }
    }
    CHECK(solved.size() == 125);
    CHECK(b.planner.space().size() == 125);
    CHECK(b.told.size() == 125);
  }
}

TEST_CASE("planner: a cancelled solve leaves nothing behind and is tried again") {
  Bench b(virtual_options(), 1);
  b.planner.plan(0);
  REQUIRE(b.generator.jobs.size() == 1);
  const Vec3 x = b.generator.jobs.at(0).at;
  b.planner.receive(b.generator.end(0, 0.001, SolveStatus::cancelled), 0.001);
  CHECK(b.planner.space().size() == 0);
  CHECK(b.told.empty());
  CHECK(b.planner.preempted() == 1);
  b.planner.plan(0.002);
  REQUIRE(b.generator.jobs.size() == 1);
  CHECK(b.generator.jobs.at(0).at == x);
  SessionResult result;
  b.planner.finish(result, b.models);
  REQUIRE(result.dispatch.size() == 2);
  CHECK(result.dispatch[0].status == DispatchStatus::preempted);
  CHECK(std::isnan(result.dispatch[0].known));  // nothing became known
}

namespace {

// The policy coverage without a bound at_most(): all candidates are ranked again after each dispatch.
class RankedAnew final : public Policy {
 public:
  std::string_view name() const override { return "ranked-anew"; }
  bool reads_surprises() const override { return true; }
  bool reads_regions() const override { return false; }
  void look(const PlannerView& view) override { policy_->look(view); }
  void pend(const PlannerView& view) override { policy_->look(view); }
  double priority(const Candidate& candidate, const PlannerView& view) const override {
    return policy_->priority(candidate, view);
  }
  void prioritise(std::span<const Candidate> candidates, const PlannerView& view,
                  std::span<double> out) const override {
    policy_->prioritise(candidates, view, out);
  }

 private:
  std::unique_ptr<Policy> policy_ = make_policy("coverage", {});
};

}  // namespace

TEST_CASE("planner: for many workers the best are found as if all were ranked anew after each dispatch") {
  register_policy("ranked-anew", [](FactoryContext&) { return std::make_unique<RankedAnew>(); });
  std::vector<std::vector<DispatchRecord>> given;
  for (const std::string policy : {"coverage", "ranked-anew"}) {
    SessionOptions options = virtual_options();
    options.planning.policy = policy;
    Bench b(options, 40, 0.1);
    double now = 0;
    for (int round = 0; round < 12; ++round) {
      now += 0.01;
      b.planner.observe({.t = now,
                         .at = 0.012 * Vec3(std::sin(9 * now), std::cos(3 * now), std::sin(2 * now)),
                         .velocity = {0.1, 0, 0}});
      b.planner.plan(now);
      for (int worker = round % 3; worker < 40; worker += 3)
        if (b.generator.jobs.count(worker)) b.planner.receive(b.generator.end(worker, now), now);
    }
    SessionResult result;
    b.planner.finish(result, b.models);
    given.push_back(std::move(result.dispatch));
  }
  REQUIRE(given[0].size() == given[1].size());
  CHECK(given[0].size() > 100);
  for (std::size_t i = 0; i < given[0].size(); ++i) {
    CAPTURE(i);
    REQUIRE(given[0][i].at == given[1][i].at);
    CHECK(given[0][i].choice.priority ==
          Approx(given[1][i].choice.priority)
              .epsilon(1e-12));  // sums over few candidates may round differently
    CHECK(given[0][i].worker == given[1][i].worker);
  }
}

TEST_CASE("planner: a failed solve is recorded and not tried again") {
  Bench b(virtual_options(), 1);
  b.planner.plan(0);
  const Vec3 x = b.generator.jobs.at(0).at;
  b.planner.receive(b.generator.end(0, 0.01, SolveStatus::diverged), 0.01);
  CHECK(b.planner.space().size() == 0);
  REQUIRE(b.told.size() == 1);
  CHECK(b.told[0].solve.status == SolveStatus::diverged);
  for (int i = 0; i < 200; ++i) {
    b.planner.plan(0.02 + 0.01 * i);
    if (b.generator.jobs.empty()) break;
    REQUIRE(b.generator.jobs.at(0).at != x);
    b.planner.receive(b.generator.end(0, 0.02 + 0.01 * i), 0.02 + 0.01 * i);
  }
  CHECK(b.planner.space().size() == 124);
  SessionResult result;
  b.planner.finish(result, b.models);
  CHECK(result.counts.start == 0);
  CHECK(result.counts.solved == 124);
  CHECK(result.counts.failed == 1);
  CHECK(result.notes.size() == 1);
}

TEST_CASE(
    "planner: preempts what no longer matters, no candidate more than twice, and never when told not to") {
  for (const bool preempt : {true, false}) {
    SessionOptions options = virtual_options();
    options.planning.policy = "nearest";
    options.planning.preempt = preempt;
    Bench b(options, 1, 0.1);
    std::map<long, int> cancelled;
    double now = 0;
    for (int round = 0; round < 400; ++round) {
      // The HIP jumps between far corners faster than a solve takes.
      now += 0.03;
      const double side = round % 2 == 0 ? 0.012 : -0.012;
      b.planner.observe({.t = now, .at = Vec3(side, side, side), .velocity = Vec3::Zero()});
      b.planner.plan(now);
      if (b.generator.cancelled.count(0)) {
        const Vec3 x = b.generator.jobs.at(0).at;
        ++cancelled[std::lround((x.x() + 10 * x.y() + 100 * x.z()) / 0.006)];
        b.planner.receive(b.generator.end(0, now, SolveStatus::cancelled), now);
      } else if (round % 5 == 4 && b.generator.jobs.count(0)) {
        b.planner.receive(b.generator.end(0, now, SolveStatus::converged, 0.1), now);
      }
    }
    CHECK((b.planner.preempted() > 0) == preempt);
    CHECK(b.planner.solved() > 50);
    for (const auto& [place, count] : cancelled) CHECK(count <= 2);
  }
}

TEST_CASE(
    "planner: tells a policy that asks by how much the model missed each state that came, and no other") {
  static std::vector<float> seen;
  class Curious final : public Policy {
   public:
    explicit Curious(bool asks) : asks_(asks) {}
    std::string_view name() const override { return "curious"; }
    bool reads_surprises() const override { return asks_; }
    void look(const PlannerView& view) override { seen.assign(view.surprises.begin(), view.surprises.end()); }
    double priority(const Candidate& c, const PlannerView&) const override { return 1.0 / (1 + c.order); }

   private:
    bool asks_;
  };
  for (const bool asks : {false, true}) {
    CAPTURE(asks);
    const std::string policy = asks ? "curious" : "not-curious";
    register_policy(policy, [asks](FactoryContext&) { return std::make_unique<Curious>(asks); });
    SessionOptions options = virtual_options();
    options.planning.policy = policy;
    seen.clear();
    Bench b(options, 1);
    double now = 0;
    for (int i = 0; i < 12; ++i) {
      now += 0.02;
      b.planner.observe({.t = now, .at = Vec3::Zero(), .velocity = Vec3::Zero()});
      b.planner.plan(now);
      b.planner.receive(b.generator.end(0, now), now);
    }
    b.planner.plan(now + 0.01);
    REQUIRE(b.planner.space().size() == 12);
    if (!asks) {
      CHECK(seen.empty());
      continue;
    }
    REQUIRE(seen.size() == 12);
    CHECK(std::isnan(seen[0]));  // before the first state there was no model
    StateSpace before(b.input.touched.space);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const State& state = b.planner.space()[StateId{static_cast<std::uint32_t>(i)}];
      if (i > 0) {
        const Vec3 model = ModelUpdater(before, options.model.fit).model_at(state.at).force(state.at);
        const double jnd = std::max(0.07 * state.force.norm(), 0.01);
        CHECK(seen[i] == Approx((model - state.force).norm() / jnd).margin(1e-4));
      }
      before.insert(state);
    }
  }
}

TEST_CASE("planner: publishes when states or travel call for it, and only then") {
  SessionOptions options = virtual_options();
  options.model.first_guess = false;  // a guess would be a model before the first state
  Bench b(options, 1);
  const auto taken = [&] {
    const auto model = b.link.models.take();
    if (model) b.link.returned.push(*model);
    return model.has_value();
  };
  b.update(0);
  CHECK_FALSE(taken());  // nothing is known
  for (int i = 0; i < 60; ++i) {
    b.planner.plan(0.01 * i);
    b.planner.receive(b.generator.end(0, 0.01 * i), 0.01 * i);
    b.update(0.01 * i);
    if (i < 30)
      CHECK(taken());  // each state is within the neighbour set
    else
      taken();
  }
  b.update(1);
  CHECK_FALSE(taken());  // nothing new
  b.planner.observe({.t = 1, .at = Vec3(0.001, 0, 0), .velocity = Vec3::Zero()});
  b.update(1);
  CHECK_FALSE(taken());  // less than a quarter of a spacing
  b.planner.observe({.t = 1.1, .at = Vec3(0.012, 0.012, 0.012), .velocity = Vec3::Zero()});
  b.update(1.1);
  CHECK(taken());
  SessionResult result;
  b.planner.finish(result, b.models);
  REQUIRE(result.switches.size() >= 31);
  CHECK(result.switches.front().cause == SwitchCause::first);
  CHECK(result.switches[1].cause == SwitchCause::states);
  CHECK(result.switches.back().cause == SwitchCause::travel);
  for (const DispatchRecord& d : result.dispatch)
    if (!std::isnan(d.first_used)) CHECK(d.first_used >= d.finished);
}

TEST_CASE("planner: recycles models even if the loop never takes one") {
  Bench b(virtual_options(), 1);
  for (int i = 0; i < 125; ++i) {
    b.planner.plan(0.01 * i);
    b.planner.receive(b.generator.end(0, 0.01 * i), 0.01 * i);
    b.update(0.01 * i);
  }
  const auto model = b.link.models.take();
  REQUIRE(model);
  // All states lie on one linear spring, so the newest model reproduces it, whichever states were chosen.
  const Vec3 x(0.001, 0.002, -0.001);
  CHECK(((*model)->force(x) + 100 * x).norm() < 1e-9);
}
