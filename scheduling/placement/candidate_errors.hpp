#pragma once
// The candidate of the largest weighted error estimate (placement_estimate.hpp), among thousands and without judging
// all of them. An estimate depends on the states around its place alone, so it stays exact until a state comes within
// reach. Before that is known again, a candidate counts as
//   c d^2: d its distance to the nearest state [m], c its estimate / d^2 when it was judged; if it never was, the
//   largest c so far
// and is judged when it would win (lazy evaluation: Minoux 1978); beyond 32 states sixteen at most for one answer,
// which is then the worst of those judged so far.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/placement/placement_estimate.hpp"

namespace forefeel {

class CandidateErrors {
 public:
  CandidateErrors(std::vector<Vec3> candidates, const StateSpaceOptions& space,
                  const EstimateOptions& options);

  void tell(const State& state);  // usable, with stiffness
  struct Worst {
    std::size_t index = 0;  // of the candidate
    double estimate = 0;    // [1]; infinite: no estimate is possible yet
  };
  // weights: of each candidate, >= 0; nullopt if all are 0. Estimates below 1e-9, where the models agree to rounding,
  // are ordered by d.
  std::optional<Worst> worst(std::span<const double> weights);
  std::size_t judged() const { return judged_; }  // estimates that were made

 private:
  struct Known {
    double estimate = 0;               // [1]
    double growth = 0;                 // c, when it was judged [1/m^2]
    double reach = 0;                  // within which a new state changes it [m]
    double distance = 0;               // to the nearest state [m]
    bool judged = false, now = false;  // ever; with the states of now
  };
  void judge(std::size_t i);
  double expected(const Known& known) const;

  std::vector<Vec3> candidates_;
  StateSpace space_;
  EstimateOptions options_;
  ErrorEstimator estimator_;
  std::vector<Known> known_;
  double growth_ = 0;  // c [1/m^2]
  std::size_t judged_ = 0;
};

}  // namespace forefeel
