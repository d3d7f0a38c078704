#pragma once
// What the loop of a touch session and its planner tell each other, without locks. The field stays; a model adds the
// states solved so far. It is immutable and lives as long as the session; the loop takes the newest.

#include <atomic>
#include <cstdint>
#include <memory>

#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/triple_buffer.hpp"
#include "scheduling/touch/touch_field.hpp"

namespace forefeel {

struct TouchModel {
  std::uint32_t serial = 0, known = 0;  // known: solved states that it holds
  std::shared_ptr<const DeepStates> deep;
};

// The newest frame, for the planner.
struct TouchSeen {
  HipSample tip;
  bool touching = false;
  SurfacePlace site;  // valid if touching
};

struct TouchLink {
  TripleBuffer<const TouchModel*> models;
  TripleBuffer<TouchSeen> seen;
  std::atomic<double> planner_beat{0};  // [s]
};

}  // namespace forefeel
