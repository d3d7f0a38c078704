#include "scheduling/workers/rank_workers.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "geometry/common/signed_vector.hpp"
#include "geometry/states/state_message.hpp"
#include "scheduling/workers/solve_job.hpp"
#include "solver/equilibrium/linear_body.hpp"

namespace forefeel {
namespace {

constexpr auto collect_pause = std::chrono::microseconds(200);

void pack(Packer& message, const Equilibrium* e) {
  message.add(std::uint8_t{e != nullptr});
  if (!e) return;
  message.add(e->at);
  message.add(e->displacements);
  message.add(e->tangent);
}

std::shared_ptr<const Equilibrium> unpack_equilibrium(Unpacker& message) {
  if (message.number<std::uint8_t>() == 0) return nullptr;
  auto e = std::make_shared<Equilibrium>();
  e->at = message.vector();
  e->displacements = message.values();
  e->tangent = message.values();
  return e;
}

Bytes packed(const Job& job) {
  Packer message;
  message.add(job.dispatch);
  message.add(job.at);
  message.add(job.site.facet);
  message.add(job.site.at);
  pack(message, job.start.get());
  message.add(std::uint32_t(job.beside.size()));
  for (const Job::Neighbour& neighbour : job.beside) {
    message.add(neighbour.dispatch);
    message.add(neighbour.at);
  }
  return message.take();
}

Job unpacked_job(Unpacker message) {
  Job job;
  job.dispatch = message.number<std::uint32_t>();
  job.at = message.vector();
  job.site.facet = message.number<std::int32_t>();
  job.site.at = message.vector();
  job.start = unpack_equilibrium(message);
  for (auto left = message.number<std::uint32_t>(); left > 0; --left) {
    const auto dispatch = message.number<std::uint32_t>();
    job.beside.push_back({.dispatch = dispatch, .at = message.vector()});
  }
  message.expect_end();
  return job;
}

Bytes packed(const JobResult& result) {
  Packer message;
  message.add(result.dispatch);
  message.add(result.finished - result.started);
  pack(message, result.state);
  pack(message, result.equilibrium.get());
  pack(message, result.partial.get());
  return message.take();
}

JobResult unpacked_result(Unpacker message, double now) {
  JobResult result;
  result.dispatch = message.number<std::uint32_t>();
  result.finished = now;
  result.started = now - message.number<double>();
  result.state = unpack_state(message);
  result.equilibrium = unpack_equilibrium(message);
  result.partial = unpack_equilibrium(message);
  message.expect_end();
  return result;
}

class RankWorkers final : public RealWorkers {
 public:
  explicit RankWorkers(RankPool& pool) : pool_(pool), given_(static_cast<std::size_t>(pool.ranks())) {}

  void begin(std::function<double()> now) override { now_ = std::move(now); }
  int workers() const override { return pool_.ranks(); }
  bool takes_jobs(int worker) const override { return pool_.takes_jobs(worker + 1); }

  void dispatch(int worker, Job job) override {
    std::vector<Given>& given = given_[worker];
    given.push_back({job.dispatch, job.at, job.site});
    for (const Job::Neighbour& n : job.beside) given.push_back({n.dispatch, n.at, job.site});
    if (takes_jobs(worker))
      pool_.send(worker + 1, job.dispatch, packed(job));
    else
      give_back(worker);
  }
  void cancel(int worker) override {
    if (takes_jobs(worker)) pool_.cancel(worker + 1);
  }

  void collect(std::vector<JobResult>& out, double timeout) override {
    out.clear();
    out.swap(late_);
    if (ended_ || !out.empty()) return;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
    do {
      for (RankEvent& event : pool_.poll()) take(std::move(event), out);
      if (!out.empty()) return;
      std::this_thread::sleep_for(collect_pause);
    } while (std::chrono::steady_clock::now() < until);
  }

  void stop() override {
    ended_ = true;
    for (RankEvent& event : pool_.stop()) take(std::move(event), late_);
  }
  std::exception_ptr failure() const override { return {}; }
  int lost() const override { return lost_; }
  std::vector<std::string> notes() const override { return pool_.notes(); }

 private:
  struct Given {
    std::uint32_t dispatch;
    Vec3 at;
    SurfacePlace site;
  };

  void take(RankEvent event, std::vector<JobResult>& out) {
    const int worker = event.rank - 1;
    if (event.kind == RankEvent::Kind::lost) {
      ++lost_;
      give_back(worker);
      out.insert(out.end(), std::make_move_iterator(late_.begin()), std::make_move_iterator(late_.end()));
      late_.clear();
    }
    if (event.kind != RankEvent::Kind::result) return;
    try {
      JobResult result = unpacked_result(Unpacker(std::move(event.content)), now_());
      std::vector<Given>& given = given_[worker];
      const auto asked = std::ranges::find(given, result.dispatch, &Given::dispatch);
      if (asked == given.end()) return;  // of a rank that was lost and is back: others do it
      if (result.state.at != asked->at || (asked->site.exists() && result.state.site != asked->site.at))
        return pool_.distrust(event.rank);
      given.erase(asked);
      result.worker = worker;
      out.push_back(std::move(result));
    } catch (const MalformedMessage&) {
      pool_.distrust(event.rank);
    }
  }

  // What the worker was given, as cancelled results.
  void give_back(int worker) {
    for (const Given& given : std::exchange(given_[worker], {})) {
      JobResult result;
      result.dispatch = given.dispatch;
      result.worker = worker;
      result.started = result.finished = now_();
      result.state.at = given.at;
      result.state.solve.status = SolveStatus::cancelled;
      late_.push_back(std::move(result));
    }
  }

  RankPool& pool_;
  std::function<double()> now_;
  SignedVector<std::vector<Given>> given_;  // to each worker, not returned yet
  std::vector<JobResult> late_;
  bool ended_ = false;
  int lost_ = 0;  // times that a rank was
};

class StateRankWorker final : public RankWorker {
 public:
  StateRankWorker(std::shared_ptr<const Body> body, const StateSolverOptions& options)
      : solver_(std::make_shared<SolverBasis>(body),
                options.sites ? nullptr : linear_basis(body, options.spacing), options) {
    solver_.prepare();
  }

  void run(Unpacker job, const Give& give, const std::stop_token& cancelled) override {
    const auto now = [start = start_] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    solve_job(solver_, unpacked_job(std::move(job)), cancelled, now,
              [&](const JobResult& result) { give(packed(result)); });
  }

 private:
  StateSolver solver_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

std::unique_ptr<RealWorkers> make_rank_workers(RankPool& pool) {
  return std::make_unique<RankWorkers>(pool);
}

std::unique_ptr<RankWorker> make_state_worker(std::shared_ptr<const Body> body,
                                              const StateSolverOptions& options) {
  return std::make_unique<StateRankWorker>(std::move(body), options);
}

}  // namespace forefeel
