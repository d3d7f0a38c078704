#pragma once
// One frame of the haptic loop, the same under both clocks:
//   device -> HIP -> newest model -> switch -> relaxation -> safety with passivity -> device (+ log)
// relaxation: the filter of a viscous body (approx/switch/relaxation.hpp). Its time step is the time since the last
// rendered frame, skipped frames included. An elastic body has no filter.
// frame() allocates nothing, locks nothing, throws nothing; the log is allocated beforehand.
//
// The end. When the loop ends, the force that is sent is zero; it falls to zero within the slew limit:
//   a session that runs to its end   its last frames are a ramp to zero: the frames needed at the slew limit, plus 25 %
//                                    because real frames are not equally long. The number of frames does not change.
//   a session that is ended early    end() begins the ramp; the frames that follow are recorded as usual
// Both clocks share the loop, so a simulated run records what a real one would send. Frames of the ramp are rendered,
// recorded and judged like all others; only `sent` differs. Under the real clock, late frames may leave some force at
// the last frame. Further frames then follow until it is zero; up to `spare` of them are recorded.

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "approx/switch/force_switch.hpp"
#include "approx/switch/relaxation.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/bar_link.hpp"
#include "scheduling/render/frame_input.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/render/spsc_queue.hpp"
#include "scheduling/render/triple_buffer.hpp"

namespace forefeel {

class InputLog;

// Time of frame k [s], rounded to whole nanoseconds: prints short and is the same on every machine.
inline double frame_time(std::size_t k, double frame) {
  return static_cast<double>(std::llround(static_cast<double>(k) * frame * 1e9)) / 1e9;
}

// The HIP in frame k, given that of the frame rendered before, `step` frames ago. If the device returns a
// non-finite position, the last one is held, and `held` grows by 1.
inline HipSample next_hip(Device& device, const HipSample& last, std::size_t k, double frame,
                          const Vec3& sent, std::size_t& held, std::size_t step = 1) noexcept {
  const double t = frame_time(k, frame);
  Vec3 x = device.position(t, sent);
  if (!x.allFinite()) {
    x = last.at;
    ++held;
  }
  const double passed = static_cast<double>(step) * frame;
  return {.t = t, .at = x, .velocity = k == 0 ? Vec3::Zero() : Vec3((x - last.at) / passed)};
}

// All data that planner and loop share. Each member has one writer and one reader.
struct LoopLink {
  TripleBuffer<const Model*> models;        // planner -> loop
  SpscQueue<const Model*, 32> returned;     // loop -> planner, which alone frees or refills them
  TripleBuffer<HipSample> hip;              // loop -> planner
  std::atomic<std::uint32_t> known{0};      // planner -> loop: number of known states
  std::atomic<double> planner_beat{0};      // planner -> loop: session time of its last step [s]
  TripleBuffer<BarEstimate> bars;           // planner -> loop
  SpscQueue<RenderedFrame, 1024> rendered;  // loop -> planner; if it is full, frames are dropped
  InputLog* inputs = nullptr;               // both record their inputs here; null: nothing is recorded
};

// Frames in which the device failed.
struct DeviceFaults {
  std::size_t held = 0;   // its position was not finite: the last one was held
  std::size_t jumps = 0;  // it moved faster than SwitchOptions::jump_speed
};

// Settings of a loop under the real clock only.
struct RealTime {
  // Session time [s], on the same steady clock as LoopLink::planner_beat; must neither allocate nor throw. Empty: each
  // frame takes place at its nominal time.
  std::function<double()> now = {};
  std::size_t spare = 0;  // records beyond those of the session's frames, for the ramp at the end
};

class RenderLoop {
 public:
  RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames,
             RealTime real = {});

  // Runs frame k, at t = k * frame. Frames may be skipped. The slew limit uses the wall time since the frame before:
  // the shorter of the times from start to start and from force to force.
  // started: when the frame began, by RealTime::now [s].
  void frame(std::size_t k, double started = 0) noexcept;
  // Begins the ramp at the end with the next frame; later calls change nothing.
  void end() noexcept { ending_ = ended_ = true; }
  // Whether the loop may stop: the force is zero, and the last frame is done or end() was called.
  bool finished() const noexcept { return sent_.isZero(0) && (ended_ || next_ >= frames_) && next_ > 0; }
  std::size_t next() const noexcept { return next_; }  // number of the last frame + 1
  // Records the cost and the wake-up lateness of the last frame; the caller measures them.
  void note_timing(double cost_us, double lateness_us) noexcept;

  const HipSample& hip() const { return hip_; }
  const Vec3& sent() const { return sent_; }                // in the last frame [N]
  const Vec3& rendered() const { return input_.rendered; }  // in the last frame [N]
  const std::vector<FrameRecord>& log() const { return log_; }
  std::vector<FrameRecord> take_log();  // the frames done so far
  // The force that would have been sent in these frames without passivity control [N]; empty if it is off.
  std::vector<Vec3> take_uncontrolled();
  const Safety& safety() const { return safety_; }
  PassivityReport passivity() const { return control_ ? control_->report() : PassivityReport{}; }
  const DeviceFaults& device_faults() const { return device_faults_; }
  std::size_t lost_models() const { return lost_models_; }  // return queue full; its size prevents that

 private:
  void give_back(const Model* model) noexcept;
  void count_jump() noexcept;
  Vec3 send(const Vec3& rendered, double started) noexcept;
  Vec3 send_controlled(const Vec3& rendered, SafetyMoment moment) noexcept;
  ForceBar bar(const ForceSwitch::Frame& frame) noexcept;

  Device& device_;
  LoopLink& link_;
  ForceSwitch switch_;
  std::optional<RelaxationFilter> filter_;  // none: the body is elastic
  BarEstimate bar_;
  Safety safety_;
  std::optional<PassivityControl> control_;  // none: passivity is observed only
  std::optional<Safety>
      without_;  // the same rules at the same positions without control, to measure the added error
  const Model* newest_model_ = nullptr;
  bool took_model_ = false;
  double frame_;
  std::size_t frames_;
  std::function<double()> now_;
  std::vector<FrameRecord> log_;
  std::vector<Vec3> uncontrolled_log_;
  std::size_t done_ = 0, lost_models_ = 0, next_ = 0;
  bool ending_ = false, ended_ = false;  // the force goes to zero; by end()
  bool recorded_ = false;                // the last frame
  double started_ = 0, sent_at_ = 0;     // last frame, by the real clock [s]
  double jump_speed_;                    // [m/s]
  DeviceFaults device_faults_;
  FrameInput input_;  // of this frame
  HipSample hip_;
  Vec3 elastic_ = Vec3::Zero(), sent_ = Vec3::Zero(), uncontrolled_ = Vec3::Zero();
  std::uint32_t model_ = 0, newest_ = 0;  // serial numbers: rendered, newest received
};

}  // namespace forefeel
