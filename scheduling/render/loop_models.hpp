#pragma once
// The models in the loop: takes the newest from the planner, changes to it by the switch, and gives back those that
// the switch no longer needs. Nothing here allocates, locks or throws.

#include <cstddef>
#include <cstdint>

#include "approx/switch/force_switch.hpp"
#include "scheduling/render/loop_link.hpp"

namespace forefeel {

class LoopModels {
 public:
  LoopModels(LoopLink& link, const SwitchOptions& options) : link_(link), switch_(options) {}

  ForceSwitch::Frame step(const Vec3& x) noexcept;

  bool came() const { return came_; }                   // a model, with the last frame
  const Model* newest() const { return newest_; }       // received; null: none yet
  std::uint32_t rendered() const { return rendered_; }  // serial number of the model that is rendered
  std::size_t lost() const { return lost_; }            // return queue full; its size prevents that

 private:
  void give_back(const Model* model) noexcept;

  LoopLink& link_;
  ForceSwitch switch_;
  const Model* newest_ = nullptr;
  bool came_ = false;
  std::uint32_t rendered_ = 0;
  std::size_t lost_ = 0;
};

}  // namespace forefeel
