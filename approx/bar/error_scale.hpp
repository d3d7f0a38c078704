#pragma once
// The scale s(x) [N] of the error of a model f~, from what is at hand at the HIP position x [m]. It is no
// bound: conformal_factors.hpp turns it into one.
//   s(x) = ||f~(x) - t(x)|| + 1/2 c d(x)^2 + 0.01 c h^2 + s0
// t(x) = f_i - K_i (x - x_i): tangent at the state i of the model that is nearest to x, d(x) its distance [m].
// Without a stiffness t is the force of that state. h: the spacing [m].
// c [N/m^2]: how fast the force departs from a tangent, the median over the states i of
//   ||f_j - f_i + K_i (x_j - x_i)|| / ||x_j - x_i||^2,   j the state nearest to i
// With one state c = 0.1 ||K|| / h, as if the stiffness changed by a tenth within a spacing.
// s0 = 1e-6 N + 1e-6 ||f~||: what the solves leave.

#include <array>
#include <cstddef>
#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

class ErrorScale {
 public:
  static constexpr std::size_t most = 16;  // states that are kept

  ErrorScale() = default;  // of no model: infinite everywhere
  // The states of a model nearest to the HIP, the first `most` of which count.
  ErrorScale(std::span<const State> nearest, double spacing);

  // force: f~(x). No allocation, no lock, nothing thrown.
  double at(const Vec3& x, const Vec3& force) const noexcept;
  bool empty() const noexcept { return count_ == 0; }

 private:
  struct Tangent {
    Vec3 at = Vec3::Zero(), force = Vec3::Zero();
    Mat3 stiffness = Mat3::Zero();
  };
  void measure_curvature();

  std::array<Tangent, most> tangents_;
  std::size_t count_ = 0;
  double curvature_ = 0, spacing_ = 0;
};

}  // namespace forefeel
