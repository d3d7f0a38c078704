#include "scheduling/session/planner.hpp"
#include "scheduling/session/session_plan.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/workers/worker_threads.hpp"
#include "small_body.hpp"

namespace {

// Keeps the jobs; the test ends their states one by one.
class HeldWorkers final : public Generator {
 public:
  explicit HeldWorkers(int count) : count_(count) {}
  int workers() const override { return count_; }
  void dispatch(int worker, Job job) override {
    REQUIRE(jobs.count(worker) == 0);
    jobs[worker] = std::move(job);
  }
  void cancel(int worker) override { cancelled.insert(worker); }
  std::map<int, Job> jobs;
  std::set<int> cancelled;

 private:
  int count_;
};

JobResult result_of(std::uint32_t dispatch, int worker, const Vec3& at, SolveStatus status) {
  JobResult result;
  result.dispatch = dispatch;
  result.worker = worker;
  result.started = result.finished = 0;
  result.state.at = at;
  result.state.solve.status = status;
  result.state.force = -100 * at;
  result.state.stiffness = 100 * Mat3::Identity();
  return result;
}

}  // namespace

TEST_CASE("batches: neighbours on the lattice share a job, and every state is still solved once") {
  for (const int batch : {1, 2, 5, 8}) {
    CAPTURE(batch);
    SessionOptions options = virtual_options();
    options.planning.batch = batch;
    const SessionInput input = small_input();
    HeldWorkers workers(2);
    const SessionPlan plan = make_plan(input, options);
    Planner planner(planner_setup(plan), workers, {.on_state = {}});
    std::set<std::tuple<long, long, long>> solved;
    std::size_t largest = 0;
    for (int round = 0; round < 200 && solved.size() < 125; ++round) {
      planner.observe(
          {.t = 0.01 * round, .at = Vec3(0.003, 0.001 * (round % 9), 0), .velocity = Vec3(0.01, 0, 0)});
      planner.plan(0.01 * round);
      REQUIRE(workers.jobs.size() <= 2);
      while (!workers.jobs.empty()) {
        const auto [worker, job] = *workers.jobs.begin();
        workers.jobs.erase(workers.jobs.begin());
        std::vector<Job::Neighbour> all{{job.dispatch, job.at}};
        for (const Job::Neighbour& neighbour : job.beside) {
          CHECK((neighbour.at - job.at).norm() < 1.1 * input.touched.space.spacing);
          all.push_back(neighbour);
        }
        largest = std::max(largest, all.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
          const Vec3 k = all[i].at / input.touched.space.spacing;
          REQUIRE(solved.insert({std::lround(k[0]), std::lround(k[1]), std::lround(k[2])}).second);
          CHECK(planner.idle() == (workers.jobs.empty() && i == all.size()));
          planner.receive(result_of(all[i].dispatch, worker, all[i].at, SolveStatus::converged),
                          0.01 * round);
        }
      }
      CHECK(planner.idle());
    }
    CHECK(solved.size() == 125);
    CHECK(planner.space().size() == 125);
    CHECK(largest <= static_cast<std::size_t>(batch));
    CHECK(largest >= static_cast<std::size_t>(std::min(batch, 4)));
  }
}

TEST_CASE("batches: what was cancelled is open again, and goes on from where it stood") {
  SessionOptions options = virtual_options();
  options.planning.batch = 4;
  options.planning.rest_first = false;  // rest has a job of its own
  HeldWorkers workers(1);
  const SessionPlan plan = make_plan(small_input(), options);
  Planner planner(planner_setup(plan), workers, {.on_state = {}});
  planner.plan(0);
  const Job first = workers.jobs.at(0);
  REQUIRE(first.beside.size() == 3);
  CHECK_FALSE(first.start);  // rest
  const auto stood = std::make_shared<Equilibrium>();
  JobResult broken = result_of(first.dispatch, 0, first.at, SolveStatus::cancelled);
  broken.partial = stood;
  broken.finished = 0.001;
  workers.jobs.clear();
  planner.receive(std::move(broken), 0.001);
  CHECK_FALSE(planner.idle());
  for (const Job::Neighbour& neighbour : first.beside)
    planner.receive(result_of(neighbour.dispatch, 0, neighbour.at, SolveStatus::cancelled), 0.001);
  CHECK(planner.idle());
  CHECK(planner.preempted() == 1);  // the others had not begun
  CHECK(planner.space().empty());
  planner.plan(0.002);
  CHECK(workers.jobs.at(0).at == first.at);
  CHECK(workers.jobs.at(0).start == stood);
}

TEST_CASE("virtual workers: neighbours cost their share, work that was broken off is not done again") {
  SessionOptions options = virtual_options(1.5);
  options.workers.count = 3;
  options.workers.cost = ConstantCost{0.05};
  options.workers.latency = 0.002;
  options.planning.batch = 4;
  options.workers.batch_share = 0.3;
  options.planning.policy = "error";
  options.motion.device = PathMotion{.path = PathName::lissajous, .speed = 0.4};
  const SessionResult result = run_session(small_input(), options);
  std::map<int, std::vector<const DispatchRecord*>> by_worker;
  for (const DispatchRecord& d : result.dispatch)
    if (d.status == DispatchStatus::solved) by_worker[d.worker].push_back(&d);
  std::map<std::tuple<double, double, double>, double> broken_off;
  for (const DispatchRecord& d : result.dispatch)
    if (d.status == DispatchStatus::preempted)
      broken_off[{d.at[0], d.at[1], d.at[2]}] += d.finished - d.started;
  int shared = 0, whole = 0, resumed = 0;
  for (auto& [worker, rows] : by_worker) {
    double busy_until = 0;
    for (const DispatchRecord* d : rows) {
      CHECK(d->started >= busy_until - 1e-9);  // one after the other
      busy_until = d->finished;
      const double took = d->finished - d->started, before = broken_off[{d->at[0], d->at[1], d->at[2]}];
      CHECK(d->known == Approx(d->finished + 0.002).margin(1e-8));
      if (d->at.isZero(0))
        CHECK(took == Approx(0.0125).margin(1e-8));  // rest, a fourth
      else if (before > 0 && ++resumed)
        CHECK((took == Approx(0.05 - before).margin(1e-8) || took <= 0.015 + 1e-8));
      else if (took == Approx(0.05).margin(1e-8))
        ++whole;
      else if (took == Approx(0.015).margin(1e-8))
        ++shared;
      else
        CHECK(took == 0);  // fails, and shows it
    }
  }
  CHECK(whole > 0);
  CHECK(shared > 0);
  CHECK(resumed > 0);
  for (const int threads : {1, 2}) {
    options.workers.threads = threads;
    const SessionResult again = run_session(small_input(), options);
    REQUIRE(again.frames.size() == result.frames.size());
    for (std::size_t k = 0; k < result.frames.size(); ++k)
      REQUIRE(again.frames[k].force == result.frames[k].force);
  }
}

TEST_CASE("batches: a worker does one thing at a time, and what has not begun has no start") {
  SessionOptions options = virtual_options(0.6);
  options.planning.batch = 4;
  options.workers.cost = LogNormalCost{0.03, 1};
  options.motion.device = PathMotion{.path = PathName::reach, .speed = 0.1};
  options.workers.count = 3;
  const SessionResult result = run_session(small_input(), options);
  std::map<int, std::vector<std::pair<double, double>>> busy;
  std::size_t never = 0, preempted = 0;
  for (const DispatchRecord& row : result.dispatch) {
    CAPTURE(row.id, row.status);
    const bool begun = row.status != DispatchStatus::waiting && row.status != DispatchStatus::withdrawn;
    CHECK(std::isfinite(row.started) == begun);
    never += !begun;
    preempted += row.status == DispatchStatus::preempted;
    if (!begun) continue;
    busy[row.worker].push_back(
        {row.started, std::isfinite(row.finished) ? row.finished : options.clock.seconds});
    if (row.parent >= 0)
      CHECK(result.dispatch[static_cast<std::size_t>(row.parent)].finished <= row.started + 1e-12);
  }
  CHECK(never > 0);
  CHECK(result.counts.preempted == preempted);
  for (auto& [worker, spans] : busy) {
    std::ranges::sort(spans);
    for (std::size_t i = 1; i < spans.size(); ++i) CHECK(spans[i - 1].second <= spans[i].first + 1e-12);
  }
}

TEST_CASE("worker threads: a job's neighbours come after it, all of them right; cancelled ones say so") {
  const auto body = test::small_body();
  StateSolver judge(std::make_shared<SolverBasis>(body), nullptr, {.spacing = 0.006});
  WorkerThreads workers(body, {.spacing = 0.006, .tolerance = 1e-6}, [] { return 0.0; });
  std::thread thread([&] { workers.serve(); });
  while (workers.workers() == 0) std::this_thread::yield();
  Job job{.dispatch = 7, .at = Vec3(0, 0.006, 0), .start = nullptr};
  for (std::uint32_t i = 0; i < 6; ++i)
    job.beside.push_back(
        {.dispatch = 8 + i, .at = job.at + (i % 2 ? -0.006 : 0.006) * Vec3::Unit(static_cast<int>(i / 2))});
  const std::vector<Job::Neighbour> beside = job.beside;
  workers.dispatch(0, job);
  std::vector<JobResult> results, all;
  while (all.size() < 7) {
    workers.collect(results, 0.01);
    for (JobResult& r : results) all.push_back(std::move(r));
  }
  CHECK(all.front().dispatch == 7);
  for (const JobResult& r : all) {
    const Vec3 at = r.dispatch == 7 ? job.at : beside[r.dispatch - 8].at;
    const State state = judge.reference(at).state;
    CHECK(r.state.at == at);
    REQUIRE(r.state.usable());
    CHECK((r.state.force - state.force).norm() <= 5e-6 * std::max(state.force.norm(), 1e-3));
  }
  workers.dispatch(0, job);
  workers.stop();
  thread.join();
  workers.collect(results, 0);
  for (const JobResult& r : results)
    CHECK((r.state.usable() || r.state.solve.status == SolveStatus::cancelled));
}
