#include "apps/generate/site_ranks.hpp"

#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <utility>

#include "geometry/common/packer.hpp"
#include "geometry/states/state_message.hpp"

namespace forefeel {
namespace {

class SiteWorker final : public RankWorker {
 public:
  SiteWorker(std::shared_ptr<const RestSites> sites, double step) : sites_(std::move(sites)), step_(step) {}
  void run(Unpacker job, const Give& give, const std::stop_token&) override {
    SitedPlace place;
    place.site.facet = job.number<std::int32_t>();
    place.site.at = job.vector();
    place.x = job.vector();
    job.expect_end();
    Packer result;
    pack(result, solve_place(*sites_, place, step_));
    give(result.take());
  }

 private:
  std::shared_ptr<const RestSites> sites_;
  double step_;
};

// One list of places after the other.
class PlacesWork final : public FarmWork {
 public:
  using Done = std::function<void(State, std::size_t)>;

  void solve(std::span<const SitedPlace> places, const Done& done) {
    std::unique_lock lock(mutex_);
    if (ended_ || places.empty()) return;
    first_ += places_.size();
    places_ = places, done_ = &done, left_ = places.size();
    for (std::size_t i = 0; i < places.size(); ++i) open_.push_back(i);
    grew_ = true;
    changed_.wait(lock, [&] { return left_ == 0 || ended_; });
    done_ = nullptr, open_.clear();
  }
  // Nothing more is wanted, or solved.
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  std::optional<Piece> next(int) override {
    const std::lock_guard lock(mutex_);
    if (open_.empty()) return {};
    const std::size_t i = open_.front();
    open_.pop_front();
    Packer message;
    message.add(places_[i].site.facet);
    message.add(places_[i].site.at);
    message.add(places_[i].x);
    return Piece{first_ + i, message.take()};
  }
  void done(std::uint64_t id, int, Unpacker result) override {
    State state = unpack_state(result);
    result.expect_end();
    const std::lock_guard lock(mutex_);
    if (done_ == nullptr || id < first_) return;
    (*done_)(std::move(state), id - first_);
    if (--left_ == 0) changed_.notify_all();
  }
  void again(std::uint64_t id) override {
    const std::lock_guard lock(mutex_);
    if (done_ != nullptr && id >= first_) open_.push_front(id - first_);
  }
  bool grew() override {
    const std::lock_guard lock(mutex_);
    return std::exchange(grew_, false);
  }
  bool finished() const override {
    const std::lock_guard lock(mutex_);
    return ended_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::span<const SitedPlace> places_;
  const Done* done_ = nullptr;
  std::deque<std::size_t> open_;
  std::uint64_t first_ = 0;  // of the list; numbers of earlier ones are below
  std::size_t left_ = 0;
  bool grew_ = false, ended_ = false;
};

}  // namespace

FarmReport with_ranks(RankPool& pool, const std::shared_ptr<const RestSites>& sites, double step,
                      const FarmOptions& options, const std::function<void(const SolvePlaces&)>& work) {
  PlacesWork places;
  auto running = std::async(std::launch::async, [&] {
    struct End {
      PlacesWork& places;
      ~End() { places.end(); }
    } end{places};
    work([&](std::span<const SitedPlace> list, const PlacesWork::Done& done) { places.solve(list, done); });
  });
  const LoadWorker own = [&](const RankContext&) {
    return LoadedWorker{.worker = make_site_worker(sites, step), .identity = {}};
  };
  struct End {  // where the farm throws, the thread must not wait for ever
    PlacesWork& places;
    ~End() { places.end(); }
  } end{places};
  FarmReport report = run_farm(pool, places, own, options);
  places.end();
  running.get();
  return report;
}

std::unique_ptr<RankWorker> make_site_worker(std::shared_ptr<const RestSites> sites, double step) {
  return std::make_unique<SiteWorker>(std::move(sites), step);
}

}  // namespace forefeel
