#include "scheduling/render/bare_loop.hpp"

#include "scheduling/render/loop_thread.hpp"

namespace forefeel {

BareLoop::BareLoop(double frame, std::size_t frames)
    : frame_(frame), frames_(frames), thread_([this] { run(); }) {}

BareLoop::~BareLoop() {
  end();
}

void BareLoop::begin(std::int64_t start) noexcept {
  std::int64_t none = 0;
  if (start_.compare_exchange_strong(none, start)) start_.notify_all();
}

void BareLoop::end() {
  ended_.store(true);
  begin(-1);  // if it waits
  if (!thread_.joinable()) return;
  thread_.join();
  frames_.resize(done_);
}

void BareLoop::run() {
  note_ = become_loop_thread();
  start_.wait(0);
  const std::int64_t start = start_.load();
  if (start < 0) return;
  FramePacer pacer(frame_, frames_.size());
  while (done_ < frames_.size() && !ended_.load(std::memory_order_relaxed)) {
    sleep_until(start + pacer.due());
    const std::int64_t woke = monotonic();
    const std::size_t k = pacer.begin(woke - start);
    frames_[k] = {.cost_us = static_cast<double>(monotonic() - woke) / 1e3,
                  .lateness_us = static_cast<double>(pacer.lateness()) / 1e3};
    done_ = k + 1;
  }
}

}  // namespace forefeel
