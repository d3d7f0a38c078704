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

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "approx/switch/relaxation.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/render/contact.hpp"
#include "scheduling/render/force_output.hpp"
#include "scheduling/render/frame_input.hpp"
#include "scheduling/render/loop_link.hpp"
#include "scheduling/render/render_options.hpp"
#include "scheduling/render/tip_reader.hpp"

namespace forefeel {

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
  void record(const ForceSwitch::Frame& frame, const ForceBar& bar, const TouchRecord& touch) noexcept;

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
