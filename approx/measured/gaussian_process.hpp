#pragma once
// Gaussian process regression of measured forces (Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006,
// ch. 2 and 5). Each component c of the force is a constant plus a random field of one law for all three, so that the
// result turns with the axes:
//   f_c(x) = m_c + g_c(x),   cov(g_c(x), g_c(x')) = a^2 r(|x - x'| / l),   measured: F_ic = f_c(x_i) + noise
//   f~(x)  = m + k(x)^T (R + D)^-1 (F - 1 m),   k_i = r(|x - x_i| / l),   D_ii = (sigma / a)^2 / w_i
//   v(x)   = a^2 (1 - k^T (R + D)^-1 k + (1 - 1^T (R + D)^-1 k)^2 / 1^T (R + D)^-1 1)
// a [N], l [m]: amplitude and length of the field. sigma [N]: noise of one component of one row; w_i: rows averaged in
// i. v [N^2]: variance of f_c(x) - f~_c(x), without noise. m is the mean of generalised least squares.
// Nothing is fitted to a direction in which the rows do not differ: there the force stays near that of the nearest
// rows, and v grows as the field varies elsewhere.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "approx/model/model_options.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// Measured forces; weight: rows averaged in each, of the same length as at and force.
struct MeasuredRows {
  std::vector<Vec3> at, force;  // [m], [N]
  std::vector<double> weight;
  std::size_t size() const { return at.size(); }
  void add(const Vec3& x, const Vec3& f, double w = 1) {
    at.push_back(x), force.push_back(f), weight.push_back(w);
  }
};

// The most likely law (restricted likelihood) of one smoothness. noise: known sigma [N], else it is sought as well.
// Nothing for fewer than 4 rows or rows at one place. O(n^3), some fifty times: give at most a few hundred rows.
struct LikelyLaw {
  FieldLaw law;
  double minus_log_likelihood = 0;  // up to a constant of the rows
};
std::optional<LikelyLaw> likely_law(const MeasuredRows& rows, Smoothness smoothness,
                                    std::optional<double> noise = {});

// The likeliest law of other rows found from `law` in some steps of a search; with no steps its own likelihood, with
// the likeliest amplitude. O(n^3) a step.
struct LawSearch {
  int steps = 0;
  std::optional<double> noise = {};  // known sigma [N]
  double longest = 100;              // l, in distances of the rows from their middle (root mean square)
};
std::optional<LikelyLaw> improved_law(const MeasuredRows& rows, const FieldLaw& law, const LawSearch& search);

// How well a law predicts groups of rows from all others, without fitting again (Rasmussen, Williams, 5.4.2). With
// e_i and v_i the error and the variance of row i when its group is left out, and c the mean of |e_i|^2 / (3 v_i):
//   score of a group: mean of |e_i|^2 / (2 c v_i) + 3/2 log(c v_i); less is better
// The likelihood asks whether the law explains all rows; a law that takes a kink for noise may do so, and be sure of
// what it misses. A grouping: the group of each row, from 0 without gaps. Empty if the law does not fit. O(n^3).
using Grouping = std::vector<std::uint32_t>;
std::vector<std::vector<double>> left_out_scores(const MeasuredRows& rows, const FieldLaw& law,
                                                 std::span<const Grouping> groupings);

class GaussianProcess {
 public:
  struct Prediction {
    Vec3 force = Vec3::Zero();  // f~ [N]
    double deviation = 0;       // sqrt(v) [N]
  };
  // O(n^3). At least one row.
  GaussianProcess(MeasuredRows rows, const FieldLaw& law);
  Vec3 force(const Vec3& x) const;     // O(n)
  Prediction at(const Vec3& x) const;  // O(n^2)

 private:
  Eigen::VectorXd correlations(const Vec3& x) const;

  MeasuredRows rows_;
  FieldLaw law_;
  Eigen::MatrixXd lower_;                             // Cholesky factor of R + D
  Eigen::VectorXd ones_;                              // (R + D)^-1 1
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights_;  // (R + D)^-1 (F - 1 m)
  Eigen::RowVector3d mean_;                           // m
};

}  // namespace forefeel
