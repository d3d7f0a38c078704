#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "geometry/states/state_file.hpp"

namespace forefeel {

struct StateWriter::Impl {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds patience{20};

  StateFile file;  // used by the background thread only
  std::mutex mutex;
  std::condition_variable wake, done;
  std::vector<State> waiting;
  Clock::time_point first_waiting;
  std::size_t pushed = 0, written = 0;
  bool hurry = false, stop = false;
  std::exception_ptr failure;
  std::thread thread;

  explicit Impl(StateFile opened) : file(std::move(opened)), thread([this] { run(); }) {}
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    wake.notify_one();
    thread.join();
  }

  void run() {
    std::vector<State> batch;
    std::unique_lock lock(mutex);
    for (;;) {
      wake.wait(lock, [&] { return stop || !waiting.empty(); });
      if (waiting.empty()) return;
      // Waits for more states: they share one flush to the disk.
      wake.wait_until(lock, first_waiting + patience, [&] { return stop || hurry; });
      batch.swap(waiting);
      hurry = false;
      lock.unlock();
      std::exception_ptr problem;
      try {
        file.append(batch);
      } catch (...) {
        problem = std::current_exception();
      }
      lock.lock();
      if (!problem) written += batch.size();
      batch.clear();
      if (problem) failure = problem, waiting.clear();
      done.notify_all();
      if (problem) return;
    }
  }
};

StateWriter::StateWriter(StateFile file) : impl_(std::make_unique<Impl>(std::move(file))) {}
StateWriter::~StateWriter() = default;
StateWriter::StateWriter(StateWriter&&) noexcept = default;
StateWriter& StateWriter::operator=(StateWriter&&) noexcept = default;

void StateWriter::push(State state) {
  bool first = false;
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->failure) std::rethrow_exception(impl_->failure);
    first = impl_->waiting.empty();
    if (first) impl_->first_waiting = Impl::Clock::now();
    impl_->waiting.push_back(std::move(state));
    ++impl_->pushed;
  }
  if (first) impl_->wake.notify_one();  // the thread sees further states without a signal
}

std::size_t StateWriter::written() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->written;
}

void StateWriter::flush() {
  std::unique_lock lock(impl_->mutex);
  const std::size_t all = impl_->pushed;
  impl_->hurry = !impl_->waiting.empty();
  impl_->wake.notify_one();
  impl_->done.wait(lock, [&] { return impl_->failure || impl_->written >= all; });
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

}  // namespace forefeel
