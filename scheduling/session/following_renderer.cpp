#include "scheduling/session/following_renderer.hpp"

#include <limits>

#include "scheduling/render/input_log.hpp"

namespace forefeel {

FollowingRenderer::FollowingRenderer(const StateSpace& known, const RunRendering& rendering,
                                     std::size_t frames, InputLog* inputs)
    : models_(known, rendering.model, link_),
      loop_(motion_, link_, rendering.options, frames),
      frame_(rendering.options.frame) {
  link_.inputs = inputs;
}

double FollowingRenderer::Motion::duration() const {
  return std::numeric_limits<double>::infinity();
}

void FollowingRenderer::frame(const PassedFrame& frame) {
  const double now = frame_time(frame.k, frame_);
  models_.update(now, motion_.at);  // for the last known position of the HIP
  motion_.at = frame.at;
  link_.known.store(frame.known, std::memory_order_relaxed);
  link_.planner_beat.store(now, std::memory_order_relaxed);
  if (frame.ending) loop_.end();
  loop_.frame(frame.k);
  if (link_.inputs && frame.k % 1024 == 1023) link_.inputs->drain();
  force_.store(loop_.log()[frame.k].force.norm(), std::memory_order_relaxed);
  label_.store(models_.label(), std::memory_order_relaxed);
}

}  // namespace forefeel
