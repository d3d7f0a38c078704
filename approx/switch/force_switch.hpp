#pragma once
// The damped coefficient switch (paper 3.2): from model f~ to model f~' without a jump that the hand feels.
//   paper   F = (1 - w) f~ + w f~'   w changes every tenth frame by |dF| <= max(10 mN, 7 % |F|)
//   smooth  F = f~' + e              e = F - f~' at the moment of the switch, then shrinks in every frame by
//                                    |dF| <= max(1 mN, 0.7 % |F|); a newer model only redefines e
//   none    F = f~'                  at once
// F [N] is the rendered force. dF [N] is the change by the switch at the frame's own x; motion does not
// count. The bound holds for |F| before and after the change. The first model fades in from zero by the same
// rule. paper: models that arrive during a switch wait; only the latest of them is used. If f~ and f~' differ
// by d at the HIP, the switch takes at most d / 10 mN steps of 10 ms, which bounds the delay. smooth: no
// delay; the offset is gone after at most |e| / 1 mN frames. step() does not allocate, lock or throw.

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
    double bound = 0;              // the rule's bound on |dF| in this frame; rule none: that of smooth [N]
    double undamped_jump = 0;      // |f~' - f~| at x in the frame where a new model is taken, else 0 [N]
    bool took_model = false;
    const Model* released = nullptr;  // no longer needed by the loop; return it to the planner
    const Model* released_too = nullptr;
  };
  // newest: the latest published model, or null if none was published since the last frame.
  Frame step(const Model* newest, const Vec3& x) noexcept;
  // The same from forces at x: `old` of the previous model, `now` of the newest; comes: the newest is new in
  // this frame. Not for rule paper, which needs both models for longer.
  Frame step(const Vec3& old, const Vec3& now, bool comes) noexcept;

 private:
  Frame step_smooth(const Model* newest, const Vec3& x) noexcept;  // and none
  Frame step_paper(const Model* newest, const Vec3& x) noexcept;

  SwitchOptions options_;
  const Model* current_ = nullptr;
  const Model* previous_ = nullptr;  // rule paper only
  const Model* waiting_ = nullptr;   // rule paper: the latest model that arrived during a switch
  Vec3 offset_ = Vec3::Zero();
  double weight_ = 1;
  int frames_since_step_ = 1 << 20;  // the first step is taken at once
};

}  // namespace forefeel
