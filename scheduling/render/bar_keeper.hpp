#pragma once
// Makes the estimates from which the loop computes its error bars (bar_link.hpp), and calibrates them: each
// state that arrives is first predicted, then compared.
//   audit     a state at a position that the loop rendered within the last seconds: the score of what the
//             hand felt there. It counts 1.
//   other     within 1.5 spacings of the HIP: the score of the model in use, at that position. Such states
//             are solved where ignorance is largest, not where the hand is: they count 0.05, and nothing
//             once their label has 20 audits.
// Until there are scores, those of other bodies and motions stand in for them (approx/bar/prior_scores.hpp).
// The error of a first model, of no states, is unknown: its bar is infinite.

#include <array>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "geometry/index/path_walk.hpp"
#include "scheduling/render/bar_link.hpp"
#include "scheduling/render/render_loop.hpp"

namespace forefeel {

class BarKeeper {
 public:
  // Both must outlive the keeper; one thread owns keeper and space.
  BarKeeper(const StateSpace& space, LoopLink& link);

  // Before the next model is made: scores the states that have come since. model: the newest; null: none.
  void learn(const Model* model);
  void publish(const Vec3& hip, const Model& model);

 private:
  const RenderedFrame* rendered_at(const Vec3& x) const;
  void learn_from(const State& state, const Model* model);

  const StateSpace& space_;
  LoopLink& link_;
  ConformalFactors factors_;
  PathWalk walk_;
  std::vector<RenderedFrame> rendered_;  // a ring
  std::size_t next_ = 0, seen_;          // place in the ring; states scored so far
  std::array<std::size_t, 4> audits_{};  // by label
  Vec3 hip_ = Vec3::Zero();
  BarEstimate newest_;
  std::vector<State> near_;
};

}  // namespace forefeel
