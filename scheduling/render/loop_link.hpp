#pragma once
// All data that planner and loop share. Each member has one writer and one reader.

#include <atomic>
#include <cstdint>

#include "approx/model/model.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/bar_link.hpp"
#include "scheduling/render/spsc_queue.hpp"
#include "scheduling/render/triple_buffer.hpp"

namespace forefeel {

class InputLog;
struct SurfaceModel;  // touch/surface_models.hpp

struct LoopLink {
  TripleBuffer<const Model*> models;           // planner -> loop
  SpscQueue<const Model*, 32> returned;        // loop -> planner, which alone frees or refills them
  TripleBuffer<const SurfaceModel*> surfaces;  // the same of a body that is touched anywhere; they stay
  TripleBuffer<HipSample> hip;                 // loop -> planner
  std::atomic<std::uint32_t> known{0};         // planner -> loop: number of known states
  std::atomic<double> planner_beat{0};         // planner -> loop: session time of its last step [s]
  TripleBuffer<BarEstimate> bars;              // planner -> loop
  SpscQueue<RenderedFrame, 1024> rendered;     // loop -> planner; if it is full, frames are dropped
  InputLog* inputs = nullptr;                  // both record their inputs here; null: nothing is recorded
};

}  // namespace forefeel
