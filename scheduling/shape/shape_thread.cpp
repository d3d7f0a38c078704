#include "scheduling/shape/shape_thread.hpp"

#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "scheduling/render/render_loop.hpp"

namespace forefeel {

ShapeThread::ShapeThread(ShapeLog& log, std::function<double()> now)
    : log_(log), now_(std::move(now)), thread_([this](const std::stop_token& stop) {
        try {
          work(stop);
        } catch (const std::exception& problem) {
          failure_ = shapes_ended(log_, problem);
        }
      }) {}

void ShapeThread::pass(const HipSample& hip, const StateSpace& space) {
  if (passed_ < space.size()) {
    const std::lock_guard lock(mutex_);
    for (; passed_ < space.size(); ++passed_)
      fresh_.push_back(space[StateId{static_cast<std::uint32_t>(passed_)}]);
  }
  hip_.publish(hip);
}

void ShapeThread::end() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

void ShapeThread::take_states() {
  {
    const std::lock_guard lock(mutex_);
    std::swap(fresh_, taken_);
  }
  for (const State& state : taken_) log_.learn(state);
  taken_.clear();
}

void ShapeThread::work(const std::stop_token& stop) {
  using Seconds = std::chrono::duration<double>;
  const double rate = log_.options().rate;
  double next = 0;  // k of the next instant
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      ending_.wait_for(lock, stop, Seconds(next / rate - now_()), [] { return false; });
    }
    if (stop.stop_requested()) return;
    const std::optional<HipSample> hip = hip_.take();
    if (!hip) {  // no new HIP since the last shape
      if (now_() > (next + 1) / rate)
        ++next, log_.miss(1);
      else
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      continue;
    }
    const auto before = std::chrono::steady_clock::now();
    take_states();
    log_.take(hip->t, hip->at);
    log_.note_cost(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before).count());
    const double due = std::max(next + 1, std::floor(now_() * rate));
    log_.miss(static_cast<std::size_t>(due - next - 1));
    next = due;
  }
}

ShapeStage::ShapeStage(ShapeLog& log, const StateSpace& known, double frame)
    : log_(log), known_(known), frame_(frame) {}

void ShapeStage::frame(const PassedFrame& frame) {
  if (failure_) return;
  try {
    follow(frame);
  } catch (const std::exception& problem) {
    failure_ = shapes_ended(log_, problem);
  }
}

void ShapeStage::follow(const PassedFrame& frame) {
  while (log_.known() < known_.size()) log_.learn(known_[StateId{static_cast<std::uint32_t>(log_.known())}]);
  const double t = frame_time(frame.k, frame_);
  if (t * log_.options().rate < static_cast<double>(taken_) - 1e-9) return;
  log_.take(t, frame.at);
  while (static_cast<double>(taken_) - 1e-9 <= t * log_.options().rate) ++taken_;
}

std::optional<std::string> take_shapes(ShapeLog& log, std::span<const FrameRecord> frames,
                                       std::span<const State> known) try {
  std::size_t taken = 0;
  for (const FrameRecord& frame : frames) {
    if (frame.t < static_cast<double>(taken) / log.options().rate - 1e-9) continue;
    while (log.known() < std::min<std::size_t>(frame.known, known.size())) log.learn(known[log.known()]);
    log.take(frame.t, frame.at, frame.touch.site);
    taken = static_cast<std::size_t>(frame.t * log.options().rate + 1e-6) + 1;
  }
  return std::nullopt;
} catch (const std::exception& problem) {
  return shapes_ended(log, problem);
}

}  // namespace forefeel
