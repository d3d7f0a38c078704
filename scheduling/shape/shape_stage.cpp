#include "scheduling/shape/shape_stage.hpp"

#include <exception>

#include "scheduling/render/render_loop.hpp"

namespace forefeel {

ShapeStage::ShapeStage(ShapeLog& log, const StateSpace& known, double frame)
    : log_(log), known_(known), frame_(frame) {}

void ShapeStage::frame(const PassedFrame& frame) {
  if (failure_) return;
  try {
    follow(frame);
  } catch (const std::exception& problem) {
    failure_ = shapes_ended(log_, problem);
  }
}

void ShapeStage::follow(const PassedFrame& frame) {
  while (log_.known() < known_.size()) log_.learn(known_[StateId{static_cast<std::uint32_t>(log_.known())}]);
  const double t = frame_time(frame.k, frame_);
  if (t * log_.options().rate < static_cast<double>(taken_) - 1e-9) return;
  log_.take(t, frame.at);
  while (static_cast<double>(taken_) - 1e-9 <= t * log_.options().rate) ++taken_;
}

}  // namespace forefeel
