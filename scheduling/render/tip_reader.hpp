#pragma once
// Where the tip is in each frame, as the device gives it, and how often the device failed. Nothing here allocates or
// throws.

#include <cmath>
#include <cstddef>

#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hip_sample.hpp"

namespace forefeel {

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

}  // namespace forefeel
