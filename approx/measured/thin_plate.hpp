#pragma once
// Thin plate spline of measured forces with noise (Duchon 1977; Wahba, Spline Models for Observational Data, 1990): the
// process of gaussian_process.hpp with a linear function in place of the constant, and no length to be sure of.
//   f_c(x) = p(x)^T b + g_c(x),   cov(g_c) = a^2 phi(|x - x'| / l),   phi(r) = r^2 log r
// p: 1 and the coordinates along the principal directions of the rows, without those in which they deviate by less than
// a hundredth of the largest deviation: noise in the positions of a line is no slope across it. l [m] is a unit: it
// changes nothing but a. Of the rows alone it is the simplest method that is in wide use, and it is sure of little.
// With Q_2 orthogonal to the values of p at the rows, w = Q_2 (Q_2^T (R + D) Q_2)^-1 Q_2^T F, and b by F - (R + D) w.

#include <Eigen/Core>
#include <optional>

#include "approx/measured/gaussian_process.hpp"

namespace forefeel {

// The most likely sigma / a (restricted likelihood) and a. Nothing for fewer than 8 rows or rows at one place. O(n^3)
// once. noise: known sigma [N].
std::optional<SplineLaw> likely_spline(const MeasuredRows& rows, std::optional<double> noise = {});

class ThinPlate {
 public:
  // O(n^3). At least one row.
  ThinPlate(MeasuredRows rows, const SplineLaw& law);
  GaussianProcess::Prediction at(const Vec3& x) const;  // O(n^2)

 private:
  MeasuredRows rows_;
  SplineLaw law_;
  Vec3 middle_ = Vec3::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> axes_;  // the principal directions of p, over l
  Eigen::MatrixXd system_;                         // R + D
  Eigen::MatrixXd reproducing_;                    // n x m: c = reproducing_ p(x), sum of c_i p(x_i) = p(x)
  Eigen::MatrixXd lower_, other_;                  // Cholesky factor of Q_2^T (R + D) Q_2, and Q_2^T
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights_;  // w
  Eigen::Matrix<double, Eigen::Dynamic, 3> linear_;   // b
};

}  // namespace forefeel
