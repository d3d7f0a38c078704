#pragma once
// The damped coefficient switch (paper 3.2): from model f~ to model f~' without a jump that the hand feels.
// At the HIP x, F [N] is the rendered force. dF [N] is the part of a frame's change that the switch makes;
// the change by the motion is not counted.
//   paper   F = (1 - w) f~(x) + w f~'(x). Every tenth frame w grows from 0 towards 1, with
//           |dF| <= max(10 mN, 7 % |F|). Models that arrive before w = 1 wait; only the latest is used. If
//           the models differ by d at the HIP, w = 1 is reached after at most d / 10 mN steps of 10 ms.
//   smooth  F = f~'(x) + e. At a switch e becomes F - f~'(x), so that F does not jump. Then e shrinks in
//           every frame, with |dF| <= max(1 mN, 0.7 % |F|), for at most |e| / 1 mN frames. No model waits.
//   none    F = f~'(x) at once.
// |F| in a bound is the smaller of the forces before and after the change. The first model fades in from zero
// by the same rule. step() does not allocate, lock or throw.
//
// How large F can be. paper: F lies between the forces of the two models at the HIP. smooth: e is the difference at an
// earlier position of the HIP, and the offsets of several switches add up. Two rules bound F while the HIP moves:
//   |F| <= S                    S [N]: the largest force so far that rule `none` would have rendered
//   e <- e exp(-(s - s0) / l)   in a frame in which the HIP moves by s > s0: a jump, faster than any hand.
//                               s0 = 1 mm in 1 ms, l = 5 mm. After 5 cm nothing of e is left.
// They act only while the HIP moves, and dF does not count them.

#include "approx/model/model.hpp"
#include "approx/switch/switch_options.hpp"

namespace forefeel {

class ForceSwitch {
 public:
  explicit ForceSwitch(SwitchOptions options = {});

  struct Step {
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
  Step step(const Model* newest, const Vec3& x) noexcept;
  // The same from forces at x: `old` of the previous model, `now` of the newest. comes: the newest model is new in
  // this frame; travel: distance that the HIP has moved since the last frame [m]. Not for rule paper, which also needs
  // both models in later frames.
  Step step(const Vec3& old, const Vec3& now, bool comes, double travel = 0) noexcept;

 private:
  Step step_smooth(const Model* newest, const Vec3& x, double travel) noexcept;  // and none
  Vec3 carried(const Vec3& old, const Vec3& now, double travel) noexcept;
  Step step_paper(const Model* newest, const Vec3& x) noexcept;

  SwitchOptions options_;
  const Model* current_ = nullptr;
  const Model* previous_ = nullptr;  // rule paper only
  const Model* waiting_ = nullptr;   // rule paper: the latest model that arrived during a switch
  Vec3 offset_ = Vec3::Zero();
  double largest_ = 0;  // S [N]
  Vec3 last_x_ = Vec3::Zero();
  bool begun_ = false;
  double weight_ = 1;
  int frames_since_step_ = 1 << 20;  // the first step is taken at once
};

}  // namespace forefeel
