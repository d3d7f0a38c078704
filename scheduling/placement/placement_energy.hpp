#pragma once
// Interpolates the stored energy from forces and stiffnesses. With y = (x - centre) / scale,
//   W(y) = p(y) + sum_i (a_i . grad_i + B_i : grad_i grad_i) |y - y_i|^m,     f = -dW/dx
// where grad_i acts on y_i, p has degree q without its constant, and a, B, p follow from -f and K at every
// state with the side conditions that the sum annihilates every p (Hermite-Birkhoff; Wendland, Scattered Data
// Approximation, 2005, ch. 16). m = 2 q + 1: |y|^9 with quartic p, |y|^7 with cubic p, |y|^5 with quadratic
// p.
//
// The result is a conservative force field from 9 numbers per state. Its error is several times smaller than that of
// interpolating each force component separately, but the fit costs O((9 n)^3). It is used in place of the unknown truth
// when an error is estimated.

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

class EnergyInterpolant {
 public:
  // Null if the states do not determine p, or lack the stiffness needed for it. flat[a]: the states do not
  // vary along axis a. Then only their stiffness describes it, and p is at most quadratic in it.
  static std::shared_ptr<const EnergyInterpolant> fit(std::span<const State* const> states, int degree,
                                                      const std::array<bool, 3>& flat = {});
  Vec3 force(const Vec3& x) const;  // [N]

 private:
  using Exponents = std::array<int, 3>;
  Vec3 centre_ = Vec3::Zero();
  double scale_ = 1;
  int power_ = 9;
  std::vector<Vec3> at_;     // scaled
  Eigen::MatrixXd weights_;  // 9 x #states: a (3), B (xx yy zz xy xz yz)
  std::vector<Exponents> monomials_;
  Eigen::VectorXd polynomial_;
};

}  // namespace forefeel
