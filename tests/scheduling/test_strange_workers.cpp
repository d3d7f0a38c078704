// Workers of a user that break the contract of generator.hpp: the session says so and goes on.

#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
#include "scheduling/workers/reference_service.hpp"
#include "small_body.hpp"

namespace {

using Change = std::function<void(std::vector<JobResult>& results)>;

// The built-in workers, whose results are changed on their way.
class Strange final : public VirtualWorkers {
 public:
  Strange(std::unique_ptr<VirtualWorkers> inner, Change change)
      : inner_(std::move(inner)), change_(std::move(change)) {}
  int workers() const override { return inner_->workers(); }
  void dispatch(int worker, Job job) override { inner_->dispatch(worker, std::move(job)); }
  void cancel(int worker) override { inner_->cancel(worker); }
  void set_now(Time now) override { inner_->set_now(now); }
  std::optional<Time> next_event() const override { return inner_->next_event(); }
  void take_event(std::vector<JobResult>& results) override {
    std::vector<JobResult> own;
    inner_->take_event(own);
    if (change_) change_(own);
    for (JobResult& result : own) results.push_back(std::move(result));  // without a clear()
  }

 private:
  std::unique_ptr<VirtualWorkers> inner_;
  Change change_;
};

SessionResult run(Change change) {
  SessionInput input = small_input(Law::linear);
  const SessionOptions options = virtual_options(0.4);
  ReferenceService references(reference_options(input), 1);
  const auto cost = make_cost(options.workers.cost, {}, {});
  input.parts.virtual_workers = std::make_shared<Strange>(
      make_virtual_workers("threads",
                           {.references = references, .cost = *cost, .count = options.workers.count}),
      std::move(change));
  SessionResult result = run_session(input, options);
  CHECK(result.failures.empty());
  CHECK(result.frames.size() == 400);
  return result;
}

std::string last_note(const SessionResult& result) {
  return result.notes.empty() ? "" : result.notes.back();
}

}  // namespace

TEST_CASE("workers that append their results do not return them twice") {
  const SessionResult result = run({});
  CHECK(result.counts.solved > 0);
  CHECK(result.counts.failed == 0);
  CHECK(result.counts.solved == result.states.size());
}

TEST_CASE("results of no running job are left out and counted") {
  const SessionResult usual = run({});
  SECTION("returned twice") {
    const SessionResult result = run([](std::vector<JobResult>& results) {
      const std::vector<JobResult> again = results;
      results.insert(results.end(), again.begin(), again.end());
    });
    CHECK(result.counts.solved == usual.counts.solved);
    CHECK_THAT(last_note(result), Contains("results that belong to no running job"));
  }
  SECTION("of a dispatch or a worker that does not exist") {
    const SessionResult result = run([](std::vector<JobResult>& results) {
      for (const int worker : {-1, 77}) {
        JobResult stray;
        stray.worker = worker;
        results.push_back(stray);
      }
      JobResult stray;
      stray.dispatch = 4'000'000'000;
      results.push_back(stray);
    });
    CHECK(result.counts.solved == usual.counts.solved);
    CHECK_THAT(last_note(result), Contains("results that belong to no running job"));
  }
}

TEST_CASE("a state at another position than asked for has failed") {
  bool first = true;
  const SessionResult result = run([&](std::vector<JobResult>& results) {
    for (JobResult& done : results)
      if (done.state.solve.status != SolveStatus::cancelled && !done.state.at.isZero(0) &&
          std::exchange(first, false))
        done.state.at.x() += 0.003;
  });
  CHECK_FALSE(first);
  CHECK(result.counts.failed == 1);
  CHECK_THAT(last_note(result), Contains("1 states at other positions than asked for"));
}
