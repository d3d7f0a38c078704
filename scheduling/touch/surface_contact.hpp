#pragma once
// The contact of a tip with a body that may be touched anywhere (touch.hpp): the site of the touch in each frame, and
// the force of the newest model at (s, x). Outside the body the force is zero at once; the slew limit of the safety
// rules bounds what a hand feels of a touch that ends under force. The error bars are made after the run
// (judge/surface_judge.hpp).

#include <memory>

#include "scheduling/render/contact.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "scheduling/touch/touch.hpp"

namespace forefeel {

class SurfaceContact final : public Contact {
 public:
  // Not for SwitchRule::paper, which needs two models in every frame.
  SurfaceContact(const TouchTask& task, LoopLink& link, const SwitchOptions& options);

  ForceSwitch::Step step(const HipSample& tip, TouchRecord& touch) noexcept override;
  bool came() const noexcept override { return came_; }
  std::uint64_t newest() const noexcept override { return model_ ? model_->serial : 0; }
  std::uint32_t rendered() const noexcept override { return model_ ? model_->serial : 0; }
  Vec3 rest() const noexcept override { return holds_ ? touch_.site.at : touch_.tip; }
  bool begins() const noexcept override { return begins_; }
  bool view(ModelView& view) noexcept override;
  ForceBar bar(const ForceSwitch::Step&) noexcept override { return {}; }

 private:
  void take(const SurfaceModel* model) noexcept;

  LoopLink& link_;
  FieldOfSites field_;
  std::optional<double> friction_;
  SwitchOptions options_;
  ForceSwitch switch_;
  Touch touch_;
  const SurfaceModel* model_ = nullptr;
  bool came_ = false, begins_ = true, holds_ = false;
};

}  // namespace forefeel
