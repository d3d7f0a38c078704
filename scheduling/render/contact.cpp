#include "scheduling/render/contact.hpp"

#include <algorithm>
#include <cmath>

namespace forefeel {

ForceSwitch::Step Grasp::step(const HipSample& tip, TouchRecord&) noexcept {
  x_ = tip.at;
  const Model* model = link_.models.take().value_or(nullptr);
  const ForceSwitch::Step frame = switch_.step(model, x_);
  came_ = model != nullptr;
  if (came_) newest_ = model;
  if (frame.took_model)  // the switch may let a model wait, and takes the latest
    rendered_ = static_cast<std::uint32_t>(newest_->serial());
  give_back(frame.released);
  give_back(frame.released_too);
  return frame;
}

void Grasp::give_back(const Model* model) noexcept {
  if (model && !link_.returned.push(model)) ++lost_;
}

bool Grasp::view(ModelView& view) noexcept {
  if (!newest_) return false;
  newest_->evaluate(x_, view.here, view.jacobian);
  view.half_way = newest_->force(0.5 * x_);
  return true;
}

ForceBar Grasp::bar(const ForceSwitch::Step& frame) noexcept {
  if (const auto newer = link_.bars.take()) bar_ = *newer;
  const bool jets = newest_ && newest_->has_jets();
  const Answer own = jets ? newest_->at({x_}) : Answer{};
  const double scale = jets ? own.error * bar_.scale.stretched() : bar_.scale.at(x_, frame.undamped);
  const double residual = (frame.force - frame.undamped).norm();
  link_.rendered.push({x_, frame.force, scale, residual, bar_.label});
  ForceBar made{.scale = scale, .trusted = own.trusted};
  for (std::size_t i = 0; i < made.half_width.size(); ++i)
    made.half_width[i] =
        std::max(std::hypot(bar_.factors[i] * scale, residual), bar_floor(frame.force, jnd_));
  return made;
}

}  // namespace forefeel
