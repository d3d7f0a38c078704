#pragma once
// Safety rules between the rendered force and a device, applied in this order:
//   non-finite guard   a force that is not finite counts as zero
//   watchdog           if the planner is silent for stale_seconds the force fades out over 0.2 s, and
//                      fades in again when the planner is back
//   start-up ramp      share t / ramp_seconds of the force
//   passivity          where it is controlled: coupling and tank (passivity.hpp)
//   clamp              |F| <= force_limit
//   slew               |F - F_before| <= slew_limit dt, so that none of the above causes a jump
//   controller         of passivity, within the same limits
//   end                while the session ends, the last force shrinks to zero at the slew limit, whatever is
//                      rendered
// dt [s] is the wall time since the force before, but at most one frame: neither an early frame nor the first one after
// a pause changes the force by more than an ordinary frame may.
// An energy observer (Hannaford and Ryu 2002) sums the work of the hand, -sum F . dx, by the trapezoid rule.
// A passive body never returns more energy than it received. Nothing here allocates or throws.

#include <cstddef>
#include <limits>

#include "geometry/common/types.hpp"
#include "scheduling/render/passivity.hpp"
#include "scheduling/render/render_options.hpp"

namespace forefeel {

struct SafetyCounts {
  std::size_t clamped = 0, slewed = 0, stale = 0, non_finite = 0;  // frames
  std::size_t ending = 0;                                          // frames of the ramp at the end
};

struct SafetyMoment {
  double t = 0;    // of the frame [s]
  double age = 0;  // time since the planner's last step [s]
  // Wall time since the last force [s]; more than a frame counts as one.
  double passed = std::numeric_limits<double>::infinity();
  bool ending = false;                  // the session ends: the force goes to zero
  PassivityControl* control = nullptr;  // null: passivity is observed only
};

class Safety {
 public:
  Safety(SafetyOptions options, double frame) : options_(options), frame_(frame) {}  // frame [s]
  // rendered: the force of the switch [N]. Returns the force for the device [N].
  Vec3 apply(const Vec3& rendered, const Vec3& x, const SafetyMoment& now) noexcept;
  Vec3 apply(const Vec3& rendered, const Vec3& x, double t, double age) noexcept {  // a frame after the last
    return apply(rendered, x, SafetyMoment{.t = t, .age = age});
  }
  // Number of frames until the force is zero, if the ramp at the end begins now and no frame is late.
  std::size_t frames_to_zero() const noexcept;

  const SafetyCounts& counts() const { return counts_; }
  double work() const { return work_; }            // sum of |F . dx| [J]
  double generated() const { return generated_; }  // largest energy returned beyond that received [J]

 private:
  Vec3 limited(const Vec3& force, double most) noexcept;
  void observe_energy(const Vec3& force, const Vec3& x) noexcept;

  SafetyOptions options_;
  double frame_;
  SafetyCounts counts_;
  Vec3 last_ = Vec3::Zero(), last_x_ = Vec3::Zero();
  bool started_ = false;
  double gain_ = 1, stored_ = 0, work_ = 0, generated_ = 0;
};

}  // namespace forefeel
