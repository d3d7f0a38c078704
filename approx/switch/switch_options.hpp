#pragma once
// How the force changes from one model to the next (force_switch.hpp).

#include <string_view>

namespace forefeel {

enum class SwitchRule { paper, smooth, none };
std::string_view name(SwitchRule rule);

struct SwitchOptions {
  SwitchRule rule = SwitchRule::smooth;
  double jnd_share = 0.07;        // of |F|
  double jnd_floor = 0.010;       // F_abs [N]
  double frame = 1e-3;            // [s]
  double paper_interval = 10e-3;  // [s]; the smooth bound per frame is the JND scaled by frame / interval
  double jump_speed = 1;          // rule smooth: speed of the HIP above which the offset e decays [m/s]
  double jump_length = 5e-3;      // travel over which it then falls to 1 / 2.718 [m]
};

}  // namespace forefeel
