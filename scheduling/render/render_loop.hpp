#pragma once
// One frame of the haptic loop, the same under both clocks:
//   device -> HIP -> contact, newest model, switch -> relaxation -> safety with passivity -> device (+ log)
// relaxation: the filter of a viscous body (approx/switch/relaxation.hpp). Its time step is the time since the last
// rendered frame, skipped frames included. An elastic body has no filter. Its memory belongs to a touch: the next one
// begins anew.
// frame() allocates nothing, locks nothing, throws nothing; the log is allocated beforehand.
//
// The end. When the loop ends, the force that is sent is zero; it falls to zero within the slew limit:
//   a session that runs to its end   its last frames are a ramp to zero: the frames needed at the slew limit, plus 25 %
//                                    because real frames are not equally long. The number of frames does not change.
//   a session that is ended early    end() begins the ramp; the frames that follow are recorded as usual
// Both clocks share the loop, so a simulated run records what a real one would send. Frames of the ramp are rendered,
// recorded and judged like all others; only `sent` differs. Under the real clock, late frames may leave some force at
// the last frame. Further frames then follow until it is zero; up to `spare` of them are recorded.

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/contact.hpp"
#include "scheduling/render/frame_input.hpp"
#include "scheduling/render/loop_link.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

// From the rendered force to the one that is sent: the safety rules, with passivity control where it is wanted, by the
// wall time that has passed. Under control note_model() goes before send(), where wants_model() asks for it. Nothing
// here allocates, locks or throws.

class ForceOutput {
 public:
  // now(): as RealTime::now; empty: each frame takes place at its nominal time.
  ForceOutput(const RenderOptions& options, std::function<double()> now);

  struct Frame {
    double started = 0, beat = 0;  // of the frame, of the planner's last step [s]
    bool ending = false;           // the force goes to zero
  };
  // Once a frame; came: there is a new model.
  bool wants_model(bool came) noexcept { return control_ && (control_->wants_model() || came); }
  void note_model(const Vec3& tip, const ModelView& model, bool came) noexcept {
    control_->note_model(tip, model, came);
  }
  void rest_at(const Vec3& rest) noexcept {
    if (control_) control_->rest_at(rest);
  }
  // Returns the force for the device [N].
  const Vec3& send(const Vec3& rendered, const HipSample& tip, const Frame& frame) noexcept;

  const Vec3& sent() const { return sent_; }
  double sent_at() const { return sent_at_; }  // by now() [s]; 0 without it
  const Safety& safety() const { return safety_; }
  bool controlled() const { return control_.has_value(); }
  // Under control: the force that the other rules alone would have sent [N].
  const Vec3& uncontrolled() const { return uncontrolled_; }
  PassivityReport passivity() const { return control_ ? control_->report() : PassivityReport{}; }

 private:
  std::function<double()> now_;
  Safety safety_;
  std::optional<PassivityControl> control_;  // none: passivity is observed only
  // The same rules at the same positions without control, to measure the added error.
  std::optional<Safety> without_;
  Vec3 sent_ = Vec3::Zero(), uncontrolled_ = Vec3::Zero();
  bool begun_ = false;
  double started_ = 0, sent_at_ = 0;  // last frame, by now() [s]
};

// Where the tip is in each frame, as the device gives it, and how often the device failed. Nothing here allocates or
// throws.

// Time of frame k [s], rounded to whole nanoseconds: prints short and is the same on every machine.
inline double frame_time(std::size_t k, double frame) {
  return static_cast<double>(std::llround(static_cast<double>(k) * frame * 1e9)) / 1e9;
}

// Frames in which the device failed.
struct DeviceFaults {
  std::size_t held = 0;   // its position was not finite: the last one was held
  std::size_t jumps = 0;  // it moved faster than SwitchOptions::jump_speed
};

class TipReader {
 public:
  TipReader(Device& device, double frame, double jump_speed)  // [s], [m/s]
      : device_(device), frame_(frame), jump_speed_(jump_speed) {}

  // The tip in frame k. sent: force of the frame read before [N]. Frames may be skipped.
  const HipSample& read(std::size_t k, const Vec3& sent) noexcept;

  const HipSample& tip() const { return tip_; }
  bool held() const { return held_; }                  // in the frame read last
  std::size_t next() const noexcept { return next_; }  // number of that frame + 1
  const DeviceFaults& faults() const { return faults_; }

 private:
  Device& device_;
  double frame_, jump_speed_;
  HipSample tip_;
  bool held_ = false;
  std::size_t next_ = 0;
  DeviceFaults faults_;
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
  // contact: null: a Grasp.
  RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames,
             RealTime real = {}, std::unique_ptr<Contact> contact = nullptr);

  // Runs frame k, at t = k * frame. Frames may be skipped. The slew limit uses the wall time since the frame before:
  // the shorter of the times from start to start and from force to force.
  // started: when the frame began, by RealTime::now [s].
  void frame(std::size_t k, double started = 0) noexcept;
  // Begins the ramp at the end with the next frame; later calls change nothing.
  void end() noexcept { end_.ending = end_.early = true; }
  // Whether the loop may stop: the force is zero, and the last frame is done or end() was called.
  bool finished() const noexcept {
    return sent().isZero(0) && (end_.early || next() >= end_.frames) && next() > 0;
  }
  std::size_t next() const noexcept { return tip_.next(); }  // number of the last frame + 1
  // Records the cost and the wake-up lateness of the last frame; the caller measures them.
  void note_timing(double cost_us, double lateness_us) noexcept;

  const HipSample& hip() const { return hip_; }
  const Vec3& sent() const { return output_.sent(); }       // in the last frame [N]
  const Vec3& rendered() const { return input_.rendered; }  // in the last frame [N]
  const std::vector<FrameRecord>& log() const { return log_.frames; }
  std::vector<FrameRecord> take_log();  // the frames done so far
  // The force that would have been sent in these frames without passivity control [N]; empty if it is off.
  std::vector<Vec3> take_uncontrolled();
  const Safety& safety() const { return output_.safety(); }
  PassivityReport passivity() const { return output_.passivity(); }
  const DeviceFaults& device_faults() const { return tip_.faults(); }
  std::size_t lost_models() const { return contact_->lost(); }

 private:
  struct End {
    std::size_t frames = 0;              // of the session
    bool ending = false, early = false;  // the force goes to zero; by end()
  };
  struct Log {  // allocated beforehand
    std::vector<FrameRecord> frames;
    std::vector<Vec3> uncontrolled;
    std::size_t done = 0;
    bool has_last = false;  // the last frame
  };
  void send(double started) noexcept;
  Vec3 relaxed(const Vec3& elastic, double dt) noexcept;
  void record(const ForceSwitch::Step& frame, const ForceBar& bar, const TouchRecord& touch) noexcept;

  LoopLink& link_;
  TipReader tip_;
  HipSample hip_;
  std::unique_ptr<Contact> contact_;
  std::optional<RelaxationFilter> fresh_, filter_;  // none: the body is elastic
  ForceOutput output_;
  End end_;
  Log log_;
  FrameInput input_;             // of this frame
  Vec3 elastic_ = Vec3::Zero();  // by the switch, in the frame before [N]
};

}  // namespace forefeel
