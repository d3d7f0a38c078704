#include "scheduling/workers/farm.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "geometry/common/signed_vector.hpp"
#include "scheduling/workers/transport.hpp"

namespace forefeel {
namespace {

constexpr auto pause = std::chrono::microseconds(300);
constexpr auto tick_pause = std::chrono::milliseconds(100);

// Worker 0: the solving thread of rank 0.
class OwnThread {
 public:
  struct Result {
    std::uint64_t id;
    Bytes content;
  };

  explicit OwnThread(const LoadWorker& load)
      : thread_([this, &load](const std::stop_token& stop) { run(load, stop); }) {}
  ~OwnThread() { end(); }
  OwnThread(const OwnThread&) = delete;
  OwnThread& operator=(const OwnThread&) = delete;

  void add(FarmWork::Piece piece) {
    const std::lock_guard lock(mutex_);
    pieces_.push_back(std::move(piece));
    wake_.notify_one();
  }
  std::deque<Result> take_results() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    return std::exchange(results_, {});
  }
  std::deque<Bytes> take_questions() {
    const std::lock_guard lock(mutex_);
    return std::exchange(questions_, {});
  }
  void receive(Bytes answer) { listener_.receive(std::move(answer)); }
  // Waits a little for a result of this thread.
  void rest() {
    std::unique_lock lock(mutex_);
    done_.wait_for(lock, pause, [&] { return !results_.empty() || !questions_.empty() || failure_; });
  }
  void end() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(const LoadWorker& load, const std::stop_token& stop) {
    try {
      const LoadedWorker loaded =
          load({.ended = stop,
                .ask = [this](Bytes question) { add_question(std::move(question)); },
                .listen = [this](RankListener::Receive receive) { listener_.set(std::move(receive)); }});
      while (auto piece = next(stop)) {
        loaded.worker->run(
            Unpacker(std::move(piece->content)), [&](Bytes content) { give(piece->id, std::move(content)); },
            stop);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      done_.notify_one();
    }
  }
  std::optional<FarmWork::Piece> next(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!wake_.wait(lock, stop, [&] { return !pieces_.empty(); }) || stop.stop_requested()) return {};
    FarmWork::Piece piece = std::move(pieces_.front());
    pieces_.pop_front();
    return piece;
  }
  void give(std::uint64_t id, Bytes content) {
    const std::lock_guard lock(mutex_);
    results_.push_back({id, std::move(content)});
    done_.notify_one();
  }

  void add_question(Bytes question) {
    const std::lock_guard lock(mutex_);
    questions_.push_back(std::move(question));
    done_.notify_one();
  }

  std::mutex mutex_;
  RankListener listener_;
  std::condition_variable_any wake_;
  std::condition_variable_any done_;
  std::deque<FarmWork::Piece> pieces_;
  std::deque<Result> results_;
  std::deque<Bytes> questions_;
  std::exception_ptr failure_;
  std::jthread thread_;
};

class Farm {
 public:
  Farm(RankPool& pool, FarmWork& work, const LoadWorker& own, const FarmOptions& options)
      : pool_(pool),
        work_(work),
        options_(options),
        own_(own),
        held_(static_cast<std::size_t>(pool.ranks()) + 1) {}

  FarmReport run() {
    auto ticked = std::chrono::steady_clock::now();
    give_out();
    while (!work_.finished() && !options_.stop.stop_requested()) {
      const bool arrived = look(), news = work_.grew() || arrived;
      tell_notes();
      if (news) give_out();
      const auto now = std::chrono::steady_clock::now();
      if (options_.tick && (news || now - ticked > tick_pause)) {
        ticked = now;
        options_.tick();
      }
      if (!news) own_.rest();
    }
    return end();
  }

 private:
  // Handles results, questions and events that have arrived, and passes answers on. False if nothing has arrived.
  bool look() {
    bool news = false;
    for (OwnThread::Result& result : own_.take_results()) {
      take(0, result.id, std::move(result.content));
      news = true;
    }
    for (Bytes& question : own_.take_questions()) {
      work_.asked(0, Unpacker(std::move(question)));
      news = true;
    }
    for (RankEvent& event : pool_.poll()) {
      take(std::move(event));
      news = true;
    }
    for (FarmWork::Answer& answer : work_.answers())
      if (answer.worker == 0)
        own_.receive(std::move(answer.content));
      else
        pool_.answer(answer.worker, std::move(answer.content));
    return news;
  }

  FarmReport end() {
    FarmReport report;
    report.stopped = !work_.finished();
    report.ranks = 1 + static_cast<int>(taken_part_.size());
    own_.end();
    for (OwnThread::Result& result : own_.take_results()) take(0, result.id, std::move(result.content));
    for (RankEvent& event : pool_.stop()) take(std::move(event));
    report.lost = pool_.lost();
    tell_notes();
    return report;
  }

  void take(RankEvent event) {
    switch (event.kind) {
      case RankEvent::Kind::ready:
        taken_part_.insert(event.rank);
        break;
      case RankEvent::Kind::result:
        take(event.rank, event.job, std::move(event.content));
        break;
      case RankEvent::Kind::question:
        try {
          work_.asked(event.rank, Unpacker(std::move(event.content)));
        } catch (const MalformedMessage&) {
          pool_.distrust(event.rank);
        }
        break;
      case RankEvent::Kind::lost:
        for (const std::uint64_t id : std::exchange(held_[event.rank], {}))
          if (open_.contains(id)) work_.again(id);
        work_.lost(event.rank);
        break;
    }
  }

  // If a piece was given out twice, the result that arrives first counts.
  void take(int worker, std::uint64_t id, Bytes content) {
    std::erase(held_[worker], id);
    if (!open_.contains(id)) return;
    try {
      work_.done(id, worker, Unpacker(std::move(content)));
      open_.erase(id);
    } catch (const MalformedMessage&) {
      if (worker == 0) throw;
      held_[worker].push_back(id);
      pool_.distrust(worker);
    }
  }

  // First gives one piece to each worker, then a second one to workers that may hold more.
  void give_out() {
    for (int depth = 1; depth <= options_.queue; ++depth)
      for (int worker = 0; worker <= pool_.ranks(); ++worker) {
        auto& held = held_[worker];
        if (static_cast<int>(held.size()) >= depth || (worker > 0 && !pool_.takes_jobs(worker))) continue;
        std::optional<FarmWork::Piece> piece = work_.next(worker);
        if (!piece) continue;
        held.push_back(piece->id);
        open_.insert(piece->id);
        if (worker > 0)
          pool_.send(worker, piece->id, piece->content);
        else
          own_.add(std::move(*piece));
      }
  }

  void tell_notes() {
    for (; notes_sent_ < pool_.notes().size(); ++notes_sent_)
      if (options_.note) options_.note(pool_.notes()[notes_sent_]);
  }

  RankPool& pool_;
  FarmWork& work_;
  const FarmOptions& options_;
  OwnThread own_;
  SignedVector<std::vector<std::uint64_t>> held_;  // by each worker
  std::set<std::uint64_t> open_;                   // given out, not done
  std::set<int> taken_part_;
  std::size_t notes_sent_ = 0;
};

}  // namespace

FarmReport run_farm(RankPool& pool, FarmWork& work, const LoadWorker& own, const FarmOptions& options) {
  return Farm(pool, work, own, options).run();
}

}  // namespace forefeel
