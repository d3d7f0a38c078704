#pragma once
// All inputs of one frame of the loop, and the two forces that the loop computed. From the same inputs and the same
// models the loop computes the same forces, bit for bit (session/input_replay.hpp).

#include <cstdint>

#include "geometry/common/types.hpp"

namespace forefeel {

struct FrameInput {
  std::uint32_t frame = 0;  // its number
  std::uint32_t known = 0;  // number of known states
  std::uint64_t model = 0;  // serial number of the model that arrived in this frame; 0: none
  bool ended = false;       // the session was ended early, before this frame
  bool held = false;        // the device gave a position that is not finite: the last one was held
  double started = 0;       // of the frame, by the wall clock of the session [s]; virtual clock: 0
  double now = 0;           // when the force was computed, by the same clock [s]
  double beat = 0;          // time of the planner's last step [s]
  Vec3 at = Vec3::Zero();   // of the HIP [m]
  Vec3 rendered = Vec3::Zero(), sent = Vec3::Zero();  // [N]
};

}  // namespace forefeel
