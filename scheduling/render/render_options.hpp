#pragma once
// Settings of a render loop.

#include "approx/switch/force_switch.hpp"
#include "approx/switch/relaxation.hpp"
#include "scheduling/render/passivity.hpp"
#include "scheduling/render/safety.hpp"

namespace forefeel {

struct RenderOptions {
  SwitchOptions switching = {};
  SafetyOptions safety = {};
  double frame = 1e-3;       // [s]
  Viscosity viscosity = {};  // of the body
  PassivityOptions passivity = {};
};

}  // namespace forefeel
