#include "scheduling/judge/frame_pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace forefeel {

struct FramePipeline::Impl {
  struct Frame {
    Vec3 at;
    std::uint32_t known;
    bool ending = false;
  };
  struct Batch {
    std::vector<Frame> frames;
    std::vector<State> states;
  };
  struct Given {
    Batch batch;
    std::size_t frames = 0, states = 0;
  };
  static constexpr std::size_t batch_size = 100;

  explicit Impl(const StateSpaceOptions& options) : space(options) {}

  // ---- of the run's thread
  void flush() {
    if (given.batch.frames.empty()) return;
    {
      const std::lock_guard lock(mutex);
      batches.push_back(std::move(given.batch));
      if (!thread.joinable()) thread = std::jthread([this](const std::stop_token& stop) { work(stop); });
    }
    given.batch = {};
    changed.notify_all();
  }

  // ---- of the pipeline's thread
  void work(const std::stop_token& stop) {
    try {
      std::unique_lock lock(mutex);
      for (;;) {
        if (!changed.wait(lock, stop, [&] { return !batches.empty(); })) return;
        const Batch mine = std::move(batches.front());
        batches.pop_front();
        lock.unlock();
        arrived.insert(arrived.end(), mine.states.begin(), mine.states.end());
        for (const Frame& frame : mine.frames) {
          if (stop.stop_requested()) return;
          take(frame);
        }
        lock.lock();
        worked += mine.frames.size();
        changed.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
      changed.notify_all();
    }
  }
  void take(const Frame& frame) {
    PassedFrame passed{.k = taken++, .at = frame.at, .known = frame.known, .ending = frame.ending};
    for (; inserted < std::min<std::size_t>(frame.known, arrived.size()); ++inserted) {
      space.insert(arrived[inserted]);
      passed.grown = true;
    }
    for (const std::shared_ptr<FrameStage>& stage : stages) stage->frame(passed);
  }

  Given given;  // of the run's thread
  // of the pipeline's
  StateSpace space;
  std::vector<std::shared_ptr<FrameStage>> stages;
  std::vector<State> arrived;  // all so far, of which `inserted` are in the space
  std::size_t inserted = 0, taken = 0;
  // of both, under the mutex
  std::mutex mutex;
  std::condition_variable_any changed;
  std::deque<Batch> batches;
  std::size_t worked = 0;
  std::exception_ptr failure;
  std::jthread thread;  // the last member: it ends first
};

FramePipeline::FramePipeline(const StateSpaceOptions& space) : impl_(std::make_unique<Impl>(space)) {}
FramePipeline::~FramePipeline() = default;

void FramePipeline::add(std::shared_ptr<FrameStage> stage) {
  impl_->stages.push_back(std::move(stage));
}

const StateSpace& FramePipeline::known() const {
  return impl_->space;
}

void FramePipeline::pass(const Vec3& at, std::uint32_t known, const StateSpace& space, bool ending) {
  impl_->given.batch.frames.push_back({at, known, ending});
  ++impl_->given.frames;
  if (impl_->given.batch.frames.size() == Impl::batch_size) flush(space);
}

void FramePipeline::flush(const StateSpace& space) {
  Impl& my = *impl_;
  for (; my.given.states < space.size(); ++my.given.states)
    my.given.batch.states.push_back(space[StateId{static_cast<std::uint32_t>(my.given.states)}]);
  my.flush();
}

void FramePipeline::pass_rest(std::span<const FrameRecord> frames, std::span<const State> states) {
  Impl& my = *impl_;
  for (; my.given.states < states.size(); ++my.given.states)
    my.given.batch.states.push_back(states[my.given.states]);
  for (; my.given.frames < frames.size(); ++my.given.frames)
    my.given.batch.frames.push_back({frames[my.given.frames].at, frames[my.given.frames].known});
  my.flush();
}

void FramePipeline::wait(const ShowProgress& show) {
  Impl& my = *impl_;
  std::unique_lock lock(my.mutex);
  const auto done = [&] { return my.failure || my.worked == my.given.frames; };
  while (!my.changed.wait_for(lock, std::chrono::milliseconds(show ? 50 : 10'000), done))
    if (show)
      show({.phase = SessionPhase::labels,
            .t = static_cast<double>(my.worked),
            .seconds = static_cast<double>(my.given.frames),
            .known = my.given.states});
  if (my.failure) std::rethrow_exception(my.failure);
}

}  // namespace forefeel
