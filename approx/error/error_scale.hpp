#pragma once
// Estimates the scale s(x) [N] of the error of a model f~ at the HIP position x [m] from the states of the model (HIP:
// haptic interaction point, the tip). s is not a bound; error_bar.hpp makes error bars from it.
//   s(x) = (||f~(x) - t(x)|| + 1/2 c d(x)^2 + 0.01 c h^2 + s0) g
// t(x) = f_i - K_i (x - x_i): tangent at state i, the state of the model nearest to x, at distance d(x) [m]. If state i
// has no stiffness, t is its force. h: the spacing [m].
// c [N/m^2]: how fast the force departs from a tangent, the median over the states i of
//   ||f_j - f_i + K_i (x_j - x_i)|| / ||x_j - x_i||^2,   j the state nearest to i
// For a model of one state c = 0.1 ||K|| / h, as if the stiffness changed by a tenth within a spacing.
// s0 = 1e-6 N + 1e-6 ||f~||: the residual error of the solves. g [1]: factor for the accuracy of the model on this body
// (BodyLevel), 1 unless it is set.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "geometry/states/state.hpp"

namespace forefeel {

class ErrorScale {
 public:
  static constexpr std::size_t most = 16;  // states that are kept

  ErrorScale() = default;  // of no model: infinite everywhere
  // nearest: the states of a model by distance from the HIP; only the first `most` are used.
  ErrorScale(std::span<const State> nearest, double spacing);

  // force: f~(x). No allocation, no lock, nothing thrown.
  double at(const Vec3& x, const Vec3& force) const noexcept;
  void stretch(double g) noexcept { stretch_ = g; }
  double stretched() const noexcept { return stretch_; }  // g
  bool empty() const noexcept { return count_ == 0; }

 private:
  struct Tangent {
    Vec3 at = Vec3::Zero(), force = Vec3::Zero();  // [m], [N]
    Mat3 stiffness = Mat3::Zero();                 // [N/m]
  };
  void measure_curvature();

  std::array<Tangent, most> tangents_;
  std::size_t count_ = 0;
  double curvature_ = 0, spacing_ = 0, stretch_ = 1;
};

// Estimates from new states how accurate the model is on this body. On a smooth body the error is far below s; on a
// body that buckles it is not. Each new state updates the level l:
//   l <- l + (ln z - l) / n,   z = ||f~ - f|| / s at the new state, -9 <= ln z <= 4, n <= 100 states
// l begins at -1.85, the mean over seven bodies, which counts as 5 states. The weight of earlier states fades, so the
// level follows a body that changes. The scale s is multiplied by
//   g = exp(2 (l + 1.85))
// The exponent 2 makes the scores of different bodies most alike. Test: each of seven bodies, with a prior from the
// other six. 90 % bars then hold 81 to 96 % of the scores; without g they hold 75 to 99 %.
class BodyLevel {
 public:
  void learn(double score) {
    if (!(score > 0) || !std::isfinite(score)) return;
    count_ = std::min(count_ + 1, window);
    level_ += (std::clamp(std::log(score), -9.0, 4.0) - level_) / count_;
  }
  double stretch() const { return std::exp(exponent * (level_ - usual)); }

 private:
  static constexpr double usual = -1.85, window = 100, exponent = 2;
  double level_ = usual, count_ = 5;
};

}  // namespace forefeel
