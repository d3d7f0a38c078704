#pragma once
// The stored energy interpolated from forces and stiffnesses together: with y = (x - centre) / scale,
//   W(y) = p(y) + sum_i (a_i . grad_i + B_i : grad_i grad_i) |y - y_i|^m,     f = -dW/dx
// where grad_i acts on y_i, p has degree q without its constant, and a, B, p follow from -f and K at every
// state with the side conditions that the sum annihilates every p (Hermite-Birkhoff; Wendland, Scattered Data
// Approximation, 2005, ch. 16). m = 2 q + 1: |y|^9 with quartic p, |y|^7 with cubic p, |y|^5 with quadratic
// p.
//
// One conservative field from 9 numbers a state: several times nearer to the truth than interpolating each
// force component by itself, but O((9 n)^3). Here it stands in for the truth where an error is estimated.

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

class EnergyInterpolant {
 public:
  // Null where the states do not determine p, or carry no stiffness that is needed for it. flat[a]: nothing
  // varies along axis a but what the stiffness tells, so that p is at most quadratic in it.
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
