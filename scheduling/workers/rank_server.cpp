#include "scheduling/workers/rank_server.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "scheduling/workers/transport.hpp"

namespace forefeel {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr auto patience_with_thread = std::chrono::seconds(3);

struct Outgoing {
  RankTag tag;
  Bytes bytes;
};

// The thread that loads and solves. The thread keeps this object alive. If it does not end, it is not joined.
class SolvingThread : public std::enable_shared_from_this<SolvingThread> {
 public:
  explicit SolvingThread(LoadWorker load) : load_(std::move(load)) {}

  // Receives the data that rank 0 sends when the work begins.
  void receive_begin(Bytes message) {
    const std::lock_guard lock(mutex_);
    if (!begin_message_) begin_message_ = std::move(message);
    wake_.notify_all();
  }
  void begin() {
    if (std::exchange(begun_, true)) return;
    std::thread([self = shared_from_this()] { self->run(); }).detach();
  }
  void add(Bytes job) {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({std::move(job), {}});
    wake_.notify_one();
  }
  // Cancels the running job and the jobs queued behind it.
  void cancel() {
    const std::lock_guard lock(mutex_);
    running_.request_stop();
    for (Waiting& job : jobs_) job.stop.request_stop();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    end_.request_stop();
    running_.request_stop();
    wake_.notify_all();
  }
  bool is_running() {
    const std::lock_guard lock(mutex_);
    return begun_ && !ended_;
  }
  void receive(Bytes answer) { listener_.receive(std::move(answer)); }
  std::deque<Outgoing> take_outgoing() {
    const std::lock_guard lock(mutex_);
    return std::exchange(outgoing_, {});
  }
  // Waits a little for something to send.
  void rest() {
    std::unique_lock lock(mutex_);
    outgoing_ready_.wait_for(lock, poll_pause, [&] { return !outgoing_.empty(); });
  }

 private:
  struct Waiting {
    Bytes bytes;
    std::stop_source stop;
  };

  void run() {
    try {
      work();
    } catch (const std::exception& error) {
      fail(error.what());
    } catch (...) {
      fail("an unknown error");
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }

  void work() {
    const LoadedWorker loaded =
        load_({.ended = end_.get_token(),
               .ask = [this](Bytes question) { give(RankTag::question, std::move(question)); },
               .listen = [this](RankListener::Receive receive) { listener_.set(std::move(receive)); },
               .begun = [this] { return wait_until_begun(); }});
    Packer ready;
    ready.add(loaded.identity);
    give(RankTag::ready, ready.take());
    while (auto bytes = next()) {
      Unpacker job(std::move(*bytes));
      const auto number = job.number<std::uint64_t>();
      const auto give_result = [&](Bytes result) {
        Packer message;
        message.add(number);
        message.add_raw(result);
        give(RankTag::result, message.take());
      };
      loaded.worker->run(Unpacker(job.rest()), give_result, running_.get_token());
    }
  }

  std::optional<Bytes> next() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return end_.stop_requested() || !jobs_.empty(); });
    if (end_.stop_requested()) return {};
    Waiting job = std::move(jobs_.front());
    jobs_.pop_front();
    running_ = std::move(job.stop);
    return std::move(job.bytes);
  }

  std::optional<Bytes> wait_until_begun() {
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return end_.stop_requested() || begin_message_; });
    if (end_.stop_requested()) return {};
    return begin_message_;
  }

  void give(RankTag tag, Bytes bytes) {
    const std::lock_guard lock(mutex_);
    outgoing_.push_back({tag, std::move(bytes)});
    outgoing_ready_.notify_one();
  }
  void fail(std::string_view text) {
    Packer message;
    message.add(text);
    give(RankTag::failure, message.take());
  }

  const LoadWorker load_;
  std::mutex mutex_;
  std::condition_variable wake_, outgoing_ready_;
  std::deque<Waiting> jobs_;
  std::deque<Outgoing> outgoing_;
  std::optional<Bytes> begin_message_;
  RankListener listener_;
  std::stop_source end_, running_;  // running_ is set by the solving thread alone
  bool begun_ = false, ended_ = false;
};

// The calling thread of a rank.
class RankServer {
 public:
  RankServer(Transport& transport, LoadWorker load)
      : transport_(transport), solving_(std::make_shared<SolvingThread>(std::move(load))) {}

  ServedRank run(bool at_once) {
    if (at_once) solving_->begin();
    while (!stopped_ && silence_ < orphaned_seconds) step();
    if (!stopped_) return ServedRank::orphaned;
    solving_->end();
    for (const auto until = SteadyClock::now() + patience_with_thread;
         solving_->is_running() && SteadyClock::now() < until;)
      step();
    const bool busy = solving_->is_running();
    send_outgoing();
    send(RankTag::left);
    return busy ? ServedRank::busy : ServedRank::done;
  }

 private:
  void step() {
    while (auto message = transport_.receive()) take(std::move(*message));
    send_outgoing();
    const auto now = SteadyClock::now();
    silence_ += std::min(std::chrono::duration<double>(now - before_).count(), longest_step);
    before_ = now;
    if (now - beaten_ > std::chrono::duration<double>(beat_seconds)) {
      beaten_ = now;
      send(RankTag::beat);
    }
    solving_->rest();
  }

  void take(Message message) {
    silence_ = 0;
    switch (static_cast<RankTag>(message.tag)) {
      case RankTag::begin:
        solving_->receive_begin(std::move(message.bytes));
        solving_->begin();
        break;
      case RankTag::job:
        solving_->add(std::move(message.bytes));
        break;
      case RankTag::cancel:
        solving_->cancel();
        break;
      case RankTag::answer:
        solving_->receive(std::move(message.bytes));
        break;
      case RankTag::stop:
        stopped_ = true;
        break;
      default:
        break;
    }
  }

  void send(RankTag tag, Bytes bytes = {}) { transport_.send(0, static_cast<int>(tag), std::move(bytes)); }
  void send_outgoing() {
    for (Outgoing& message : solving_->take_outgoing()) send(message.tag, std::move(message.bytes));
  }

  Transport& transport_;
  std::shared_ptr<SolvingThread> solving_;
  SteadyClock::time_point before_ = SteadyClock::now(), beaten_ = before_;
  double silence_ = 0;  // of rank 0 [s]
  bool stopped_ = false;
};

}  // namespace

ServedRank serve_rank(Transport& transport, LoadWorker load, bool at_once) {
  return RankServer(transport, std::move(load)).run(at_once);
}

}  // namespace forefeel
