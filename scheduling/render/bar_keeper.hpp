#pragma once
// Makes the estimates from which the loop computes its error bars (bar_link.hpp). Each new state calibrates them: its
// force is compared with the force that was rendered or predicted there.
//   audit     a state at a position that the loop rendered in the last seconds. The rendered force is scored, for its
//             label and for labels with fewer than 20 audits
//   other     any other state. The model in use is scored at its position. Such states are solved where least is
//             known, not where the hand is. They show how accurate the model is on this body (BodyLevel)
// While few states are known, the scale is uncertain and the bars are wider.
// The scale of a model of energy jets is its own estimate, trust included (approx/model/jet_set.hpp); times the level.
// Until a session has scores of its own, scores of other bodies and motions are used (approx/error/error_bar.hpp).
// While no state is known, the bar of the first guess is that of a model of one state: rest, with the stiffness of the
// guess. The state at rest is then not scored, because the guess is exact there.

#include <array>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/index/path_walk.hpp"
#include "scheduling/render/loop_link.hpp"

namespace forefeel {

class BarKeeper {
 public:
  // Both must outlive the keeper; one thread owns keeper and space.
  // guess: stiffness of the first guess [N/m]; zero: none.
  BarKeeper(const StateSpace& space, const Mat3& guess, LoopLink& link);

  // Call before the next model is made. Scores the states added since the last call. model: the newest; null: none.
  void learn(const Model* model);
  void publish(const Vec3& hip, const Model& model);

 private:
  const RenderedFrame* rendered_at(const Vec3& x) const;
  void learn_from(const State& state, const Model* model);

  const StateSpace& space_;
  LoopLink& link_;
  State guessed_;  // rest with the guess; no stiffness: none
  ConformalFactors factors_;
  BodyLevel level_;
  PathWalk walk_;
  std::vector<RenderedFrame> rendered_;  // a ring
  std::size_t next_ = 0, seen_;          // place in the ring; states scored so far
  ByLabel<std::size_t> audits_{};
  BarEstimate newest_;
  std::vector<State> near_;
};

}  // namespace forefeel
