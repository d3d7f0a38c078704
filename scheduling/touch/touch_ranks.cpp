#include "scheduling/touch/touch_ranks.hpp"

#include <chrono>
#include <optional>
#include <thread>
#include <utility>

#include "geometry/common/packer.hpp"
#include "geometry/states/state_message.hpp"

namespace forefeel {
namespace {

constexpr auto touch_poll_pause = std::chrono::microseconds(200);

Bytes packed_touch(const TouchJob& job) {
  Packer message;
  message.add(job.id);
  message.add(job.site.facet);
  message.add(job.site.at);
  message.add(job.x);
  return message.take();
}

class TouchRanks final : public TouchWorkers {
 public:
  TouchRanks(RankPool& pool, std::function<double()> now)
      : pool_(pool), now_(std::move(now)), given_(static_cast<std::size_t>(pool.ranks())) {}
  ~TouchRanks() override { pool_.stop(); }

  std::vector<int> idle() override {
    std::vector<int> idle;
    for (std::size_t w = 0; w < given_.size(); ++w)
      if (!given_[w] && pool_.takes_jobs(static_cast<int>(w) + 1)) idle.push_back(static_cast<int>(w));
    return idle;
  }
  void dispatch(int worker, TouchJob job) override {
    job.start = nullptr;
    pool_.send(worker + 1, job.id, packed_touch(job));
    given_[static_cast<std::size_t>(worker)] = std::move(job);
  }
  void cancel(int worker) override {
    if (pool_.takes_jobs(worker + 1)) pool_.cancel(worker + 1);
  }
  std::vector<TouchDone> done(double timeout) override {
    std::vector<TouchDone> done;
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
    do {
      for (RankEvent& event : pool_.poll()) take_event(std::move(event), done);
      if (!done.empty()) break;
      std::this_thread::sleep_for(touch_poll_pause);
    } while (std::chrono::steady_clock::now() < until);
    return done;
  }
  std::vector<std::string> notes() const override { return pool_.notes(); }

 private:
  void take_event(RankEvent event, std::vector<TouchDone>& done) {
    std::optional<TouchJob>& job = given_[static_cast<std::size_t>(event.rank - 1)];
    const double now = now_();
    if (event.kind == RankEvent::Kind::lost && job) {
      done.push_back({job->id, event.rank - 1, now, now, cancelled(*job)});
      job.reset();
    }
    if (event.kind != RankEvent::Kind::result) return;
    try {
      Unpacker message(std::move(event.content));
      const auto id = message.number<std::uint32_t>();
      const auto seconds = message.number<double>();
      TouchSolved solved{.state = unpack_state(message)};
      message.expect_end();
      if (!job || job->id != id) return;  // of a rank that was lost and is back
      if (solved.state.site != job->site.at || solved.state.at != job->x) return pool_.distrust(event.rank);
      done.push_back({id, event.rank - 1, now - seconds, now, std::move(solved)});
      job.reset();
    } catch (const MalformedMessage&) {
      pool_.distrust(event.rank);
    }
  }

  RankPool& pool_;
  std::function<double()> now_;
  std::vector<std::optional<TouchJob>> given_;  // to each worker
};

class TouchRankWorker final : public RankWorker {
 public:
  TouchRankWorker(std::shared_ptr<const RestSites> sites, double step) : solver_(std::move(sites), step) {}

  void run(Unpacker message, const Give& give, const std::stop_token& stop) override {
    TouchJob job{.id = message.number<std::uint32_t>(), .site = {}};
    job.site.facet = message.number<std::int32_t>();
    job.site.at = message.vector();
    job.x = message.vector();
    message.expect_end();
    job.start = starts_.near(job.site, job.x);
    const auto began = std::chrono::steady_clock::now();
    TouchSolved solved = solved_by(solver_, job, stop);
    starts_.add(job.site, solved.equilibrium);
    Packer result;
    result.add(job.id);
    result.add(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    pack(result, solved.state);
    give(result.take());
  }

 private:
  TouchSolver solver_;
  TouchStarts starts_;
};

}  // namespace

std::unique_ptr<TouchWorkers> make_touch_ranks(RankPool& pool, std::function<double()> now) {
  return std::make_unique<TouchRanks>(pool, std::move(now));
}

std::unique_ptr<RankWorker> make_touch_rank_worker(std::shared_ptr<const RestSites> sites, double step) {
  return std::make_unique<TouchRankWorker>(std::move(sites), step);
}

}  // namespace forefeel
