#pragma once
// The damped coefficient switch (paper 3.2): from model f~ to f~' without a jump that the hand feels.
//   paper   (1 - w) f~ + w f~', w moves every tenth frame so that |dF| <= max(10 mN, 7 % |F|) per step
//   smooth  f~' + e, e = rendered - f~' at the moment of the switch, shrinking every frame by
//           |dF| <= max(1 mN, 0.7 % |F|); a newer model only redefines e
//   none    at once
// dF is what the switch changes at the frame's own x; |F| is the rendered force there, and the bound holds
// with |F| taken before and after the change. The first model fades in from zero by the same rule. paper: a
// model that comes while a switch is under way waits, and only the latest of them is used. With models f~,
// f~' that differ by d at the HIP the switch is over after at most d / 10 mN steps of 10 ms, which bounds the
// delay. smooth: at once; the offset is gone after at most |e| / 1 mN frames. step() allocates nothing, locks
// nothing, throws nothing.

#include <string_view>

#include "approx/model/model.hpp"

namespace forefeel {

enum class SwitchRule { paper, smooth, none };
std::string_view name(SwitchRule rule);

struct SwitchOptions {
  SwitchRule rule = SwitchRule::smooth;
  double jnd_share = 0.07;        // of |F|
  double jnd_floor = 0.010;       // F_abs [N]
  double frame = 1e-3;            // [s]
  double paper_interval = 10e-3;  // [s]; the smooth bound per frame is the JND scaled by frame / interval
};

class ForceSwitch {
 public:
  explicit ForceSwitch(SwitchOptions options = {});

  struct Frame {
    Vec3 force = Vec3::Zero();     // rendered [N]
    Vec3 undamped = Vec3::Zero();  // of the newest model at x [N]
    Vec3 change = Vec3::Zero();    // dF of this frame [N]
    double bound = 0;              // that the rule (for none: smooth) allows |dF| in this frame [N]
    double undamped_jump = 0;      // |f~' - f~| at x in the frame where a new model is taken, else 0 [N]
    bool took_model = false;
    const Model* released = nullptr;  // no longer needed by the loop; return it to the planner
    const Model* released_too = nullptr;
  };
  // newest: the latest published model, or null when nothing new came since the last frame.
  Frame step(const Model* newest, const Vec3& x) noexcept;
  // The same from forces: at x the model before gives `old` and the newest one `now`; comes: it is new in this frame.
  // Not for rule paper, which needs both models for longer.
  Frame step(const Vec3& old, const Vec3& now, bool comes) noexcept;

 private:
  Frame step_smooth(const Model* newest, const Vec3& x) noexcept;  // and none
  Frame step_paper(const Model* newest, const Vec3& x) noexcept;

  SwitchOptions options_;
  const Model* current_ = nullptr;
  const Model* previous_ = nullptr;  // rule paper only
  const Model* waiting_ = nullptr;   // rule paper: came while a switch is under way; the latest wins
  Vec3 offset_ = Vec3::Zero();
  double weight_ = 1;
  int frames_since_step_ = 1 << 20;  // the first step is taken at once
};

}  // namespace forefeel
