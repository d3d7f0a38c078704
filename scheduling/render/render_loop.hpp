#pragma once
// One frame of the haptic loop, the same under both clocks:
//   device -> HIP -> newest model -> switch -> safety -> device (+ log)
// frame() allocates nothing, locks nothing, throws nothing; the log is allocated beforehand.

#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

#include "approx/switch/force_switch.hpp"
#include "scheduling/log/records.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/safety.hpp"
#include "scheduling/render/spsc_queue.hpp"
#include "scheduling/render/triple_buffer.hpp"

namespace forefeel {

// Time of frame k [s], rounded to whole nanoseconds: prints short and is the same on every machine.
inline double frame_time(std::size_t k, double frame) {
  return static_cast<double>(std::llround(static_cast<double>(k) * frame * 1e9)) / 1e9;
}

// The HIP in frame k, given that of the frame before. If the device returns a non-finite position, the last
// one is held.
inline HipSample next_hip(Device& device, const HipSample& last, std::size_t k, double frame,
                          const Vec3& sent) noexcept {
  const double t = frame_time(k, frame);
  Vec3 x = device.position(t, sent);
  if (!x.allFinite()) x = last.at;
  return {.t = t, .at = x, .velocity = k == 0 ? Vec3::Zero() : Vec3((x - last.at) / frame)};
}

// All data that planner and loop share. Each member has one writer and one reader.
struct LoopLink {
  TripleBuffer<const Model*> models;     // planner -> loop
  SpscQueue<const Model*, 32> returned;  // loop -> planner, which alone frees or refills them
  TripleBuffer<HipSample> hip;           // loop -> planner
  std::atomic<std::uint32_t> known{0};   // planner -> loop: number of known states
  std::atomic<double> planner_beat{0};   // planner -> loop: session time of its last step [s]
};

struct RenderOptions {
  SwitchOptions switching = {};
  SafetyOptions safety = {};
  double frame = 1e-3;  // [s]
};

class RenderLoop {
 public:
  RenderLoop(Device& device, LoopLink& link, const RenderOptions& options, std::size_t frames);

  // Runs frame k, at t = k * frame.
  void frame(std::size_t k) noexcept;
  // Records the cost and the wake-up lateness of the last frame; the caller measures them.
  void note_timing(double cost_us, double lateness_us) noexcept;

  const HipSample& hip() const { return hip_; }
  const std::vector<FrameRecord>& log() const { return log_; }
  std::vector<FrameRecord> take_log();  // the frames done so far
  const Safety& safety() const { return safety_; }
  std::size_t lost_models() const { return lost_models_; }  // return queue full; its size prevents that

 private:
  void give_back(const Model* model) noexcept;

  Device& device_;
  LoopLink& link_;
  ForceSwitch switch_;
  Safety safety_;
  double frame_;
  std::vector<FrameRecord> log_;
  std::size_t done_ = 0, lost_models_ = 0;
  HipSample hip_;
  Vec3 rendered_ = Vec3::Zero(), sent_ = Vec3::Zero();
  std::uint32_t model_ = 0, newest_ = 0;  // serial numbers: rendered, newest received
};

}  // namespace forefeel
