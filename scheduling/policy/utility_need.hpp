#pragma once
// Expected utility of prefetching under an uncertain prediction (Khameleon: Mohammed, Wei, Wu, Netravali, PVLDB 13(11),
// 2020): greedy on the gain in expected error per job, under the predicted distribution of places.
//   V(c) = sum_k w_k sum_j [E(delta(q_kj)) - E(min(delta(q_kj), |q_kj - c|))] / (J T)
//   E(delta) = m / (1 + m),    ln m = a + b ln(delta / h)
// q_kj: J points of the normal distribution of the k-th prediction, mean p_k, deviation s_k per axis [m], folded into
// the box; w_k: its share of the time after T, in which a state requested now is known; T: time of a solve [s]; delta:
// distance from the nearest state that is known or being solved [m]. E is the loss at a place whose force errs by m
// JNDs: an approximate force is worth something, so the first states near a place gain most. a and b are fitted to the
// errors at the states solved so far (ErrorFit). The gain of a set of states is submodular, so the greedy order has at
// least 1 - 1/e of the best gain (Nemhauser, Wolsey, Fisher 1978).
// Unlike ErrorNeed, no weight is on the box beyond the prediction: the quality of the distribution decides.

#include <array>
#include <span>
#include <vector>

#include "scheduling/policy/error_need.hpp"
#include "scheduling/policy/policy.hpp"

namespace forefeel {

class UtilityNeed {
 public:
  struct Place {
    Vec3 at;
    double weight, delta;  // delta: of the states known and being solved [m]
  };
  void look(const PlannerView& view);        // once per planning step
  void pend(std::span<const Vec3> pending);  // replaces the states being solved [m]
  // V of each candidate [1/s]; never negative. out: #candidates.
  void worth(std::span<const Candidate> candidates, std::span<double> out) const;

  double loss(double delta) const;  // E, by linear interpolation; 0 <= delta <= 5 h
  std::span<const Place> places() const { return left_; }

 private:
  void learn(const PlannerView& view);
  void tabulate();

  const StateSpace* space_ = nullptr;
  std::size_t known_ = 0;
  double spacing_ = 0.006, solve_ = 0.01;
  ErrorFit fit_;
  std::array<double, 257> losses_{};  // E at delta = 5 h k / 256
  std::vector<Place> places_, left_;  // without and with the states being solved
  std::vector<StateId> near_;
};

}  // namespace forefeel
