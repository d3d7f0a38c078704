#include "scheduling/render/loop_models.hpp"

namespace forefeel {

ForceSwitch::Frame LoopModels::step(const Vec3& x) noexcept {
  const Model* model = link_.models.take().value_or(nullptr);
  const ForceSwitch::Frame frame = switch_.step(model, x);
  came_ = model != nullptr;
  if (came_) newest_ = model;
  if (frame.took_model)  // the switch may let a model wait, and takes the latest
    rendered_ = static_cast<std::uint32_t>(newest_->serial());
  give_back(frame.released);
  give_back(frame.released_too);
  return frame;
}

void LoopModels::give_back(const Model* model) noexcept {
  if (model && !link_.returned.push(model)) ++lost_;
}

}  // namespace forefeel
