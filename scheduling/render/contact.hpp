#pragma once
// What the tip holds, and the force of the newest model there, switched without a jump
// (approx/switch/force_switch.hpp).
//   Grasp            one place for ever: x is the position of the tip
//   SurfaceContact   a body that may be touched anywhere (touch/surface_contact.hpp)
// One object a loop. Nothing here allocates, locks or throws.

#include <cstdint>

#include "approx/switch/force_switch.hpp"
#include "scheduling/common/records.hpp"
#include "scheduling/motion/hip_sample.hpp"
#include "scheduling/render/bar_link.hpp"
#include "scheduling/render/loop_link.hpp"
#include "scheduling/render/passivity.hpp"

namespace forefeel {

class Contact {
 public:
  virtual ~Contact() = default;
  // Once a frame, with the tip of this frame.
  virtual ForceSwitch::Step step(const HipSample& tip, TouchRecord& touch) noexcept = 0;
  // What follows is of the last step.
  virtual bool came() const noexcept = 0;                      // a newer model came
  virtual std::uint64_t newest() const noexcept = 0;           // its serial number; 0: none yet
  virtual std::uint32_t rendered() const noexcept = 0;         // serial number of the model that is rendered
  virtual Vec3 rest() const noexcept { return Vec3::Zero(); }  // the tip's place at rest [m]
  virtual bool begins() const noexcept {
    return false;
  }  // a touch begins, or there is none: no memory of forces before
  virtual bool view(ModelView& view) noexcept = 0;  // of the newest model; false: there is none
  virtual ForceBar bar(const ForceSwitch::Step& frame) noexcept = 0;
  virtual std::size_t lost() const noexcept {
    return 0;
  }  // models: the queue back was full; its size prevents that
};

// Takes the newest model from the planner and gives back those that the switch no longer needs.
class Grasp final : public Contact {
 public:
  Grasp(LoopLink& link, const SwitchOptions& options) : link_(link), jnd_(options), switch_(options) {}

  ForceSwitch::Step step(const HipSample& tip, TouchRecord& touch) noexcept override;
  bool came() const noexcept override { return came_; }
  std::uint64_t newest() const noexcept override { return newest_ ? newest_->serial() : 0; }
  std::uint32_t rendered() const noexcept override { return rendered_; }
  bool view(ModelView& view) noexcept override;
  // Tells the planner what is rendered here, so that it can be scored later.
  ForceBar bar(const ForceSwitch::Step& frame) noexcept override;
  std::size_t lost() const noexcept override { return lost_; }

 private:
  void give_back(const Model* model) noexcept;

  LoopLink& link_;
  SwitchOptions jnd_;  // of the floor of the bars
  ForceSwitch switch_;
  BarEstimate bar_;
  const Model* newest_ = nullptr;
  Vec3 x_ = Vec3::Zero();
  bool came_ = false;
  std::uint32_t rendered_ = 0;
  std::size_t lost_ = 0;
};

}  // namespace forefeel
