#pragma once
// Estimates the probability that the model misses the force by more than the JND (just noticeable difference) where the
// hand will be, and how much one more state would reduce it, per second of solving.
//   V(c) = sum_q w(q) [P(m(q, delta)) - P(m(q, min(delta, |q - c|)))] / T
// q: points of the path ahead, and centres of cubes that fill the box; w(q): weight, larger the sooner the hand may be
// at q, with the sum 1; delta: distance from q to the nearest state that is known or being solved; T: time of a solve
// [s]. The error at q, in JNDs, is assumed lognormal: m is its median, v the standard deviation of its logarithm. It
// exceeds 1 with the probability
//   P(m) = N(ln m / v),   N the normal distribution function
//   ln m(q, delta) = a + b ln(delta / h) + c side(q) + r(q)
// side: distance from q to the mean of the 8 states nearest to it, over their mean distance: about 0 among states, 1
// outside of them. a, b, c, v are fitted by least squares to the errors that the model had at the states solved so far
// (PlannerView::surprises); a prior counts as some states; r(q): mean of their residuals within about 3 h.
// A model of energy jets estimates its own error m' (PlannerView::estimate, in JNDs), which was 4 times the error at
// the median. Then nothing is fitted: m = m' / 4, v = 1, and a state at the distance d lowers m' to k d^4, with k the
// median of m' / delta^4 over the box. If no m' is above 1, the policy is content: no solve is worth it.
// Why the probability and not the mean error: far from all states the error may be tens of JNDs. A mean would spend
// most solves there, where a single solve helps little.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scheduling/policy/policy.hpp"

namespace forefeel {

// A line fitted by least squares to the logarithms of errors, from a prior worth some states:
//   ln m = a + b ln(delta / h) + c side,   deviation v of the logarithm

class ErrorFit {
 public:
  ErrorFit();  // the prior

  // The logarithm of an error. Returns how far it was from the line before [1].
  double learn(double delta_over_h, double side, double log_error);

  double intercept(double side) const { return fit_[0] + fit_[2] * side; }  // ln m at delta = h
  double slope() const { return fit_[1]; }                                  // b
  double median(double delta_over_h, double side) const;                    // m
  double deviation() const;                                                 // v

 private:
  Eigen::Matrix3d normal_;  // of the least squares
  Eigen::Vector3d right_, fit_;
  double squares_, count_;  // of residuals, with the prior's
};

// ln(delta / h), held constant near a state.
double log_distance(double delta_over_h);

struct ErrorNeedOptions {
  double path_share = 0.75;  // share of the weight on the path ahead; the box has the rest
  bool shuffle = false;      // the placebo: the estimates m are permuted among the places
  std::uint64_t seed = 0;    // of the permutation
};

class ErrorNeed {
 public:
  explicit ErrorNeed(ErrorNeedOptions options) : options_(options) {}

  void look(const PlannerView& view);        // once per planning step
  void pend(std::span<const Vec3> pending);  // replaces the states being solved [m]
  // V of each candidate [1/s]; never negative. out: #candidates.
  void worth(std::span<const Candidate> candidates, std::span<double> out) const;

  bool is_content() const { return content_; }

  const ErrorFit& fit() const { return fit_; }  // m without r, and v

 private:
  static constexpr int levels = 16;
  struct Place {
    Vec3 at = Vec3::Zero();
    double weight = 0, delta = 0, side = 1;    // delta of known states [m]
    double reach = 0;                          // to the 8th state [m]
    double residuals = 0, residual_count = 0;  // weighted sum of the residuals near it, and of their weights
    double estimate = unknown;                 // m'
  };
  // What is left of the need of a place, by the distance of its nearest state.
  struct Need {
    Vec3 at = Vec3::Zero();
    double delta = 0;                        // the states being solved count [m]
    std::array<double, levels + 1> table{};  // w P at delta k / levels
  };
  struct Residual {
    Vec3 at;
    double value;
  };
  void begin(const StateSpace& space);
  void learn(const PlannerView& view);
  void see(Place& place, std::size_t before);
  void add(const Residual& residual, double sign, Place& place) const;
  void remember(const Residual& residual);
  void weigh(const PlannerView& view);
  void ask_jets(const PlannerView& view);
  // ln m / v of a place, as a function of the share of delta that a new state leaves.
  double exponent(const Place& place, double log_scale, double share) const;
  void estimate();

  ErrorNeedOptions options_;
  const StateSpace* space_ = nullptr;
  std::size_t known_ = 0, asked_ = 0;
  bool jets_ = false, content_ = false;
  double growth_ = 0;  // k [1/m^4]
  double spacing_ = 0.006, solve_ = 0.01;
  ErrorFit fit_;
  std::vector<Residual> residuals_;
  std::vector<Place> box_, places_;
  std::vector<Need> needs_;       // of places that need anything, nothing being solved
  std::vector<Need> needs_left_;  // the same with `pending`
  std::vector<StateId> near_;
};

}  // namespace forefeel
