#include "approx/measured/thin_plate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Forces = Eigen::Matrix<double, Eigen::Dynamic, 3>;
using PlateAxes = Eigen::Matrix<double, 3, Eigen::Dynamic>;

constexpr double least_extent = 0.01;  // of a direction of p, in the largest
constexpr double smallest_ratio = 1e-12, largest_ratio = 1e3, ratio_step = 1.25;
constexpr std::size_t fewest_rows = 8;

double plate(double r) {
  return r > 0 ? r * r * std::log(r) : 0;
}

// About where the rows lie, and how far they extend.
struct Scaling {
  Vec3 middle = Vec3::Zero();
  double radius = 0;  // root mean square distance from the middle [m]
  PlateAxes axes;     // principal directions over `radius`
};

Scaling scaling_of(const std::vector<Vec3>& at) {
  Scaling scaling;
  for (const Vec3& x : at) scaling.middle += x / double(at.size());
  Mat3 moment = Mat3::Zero();
  for (const Vec3& x : at)
    moment += (x - scaling.middle) * (x - scaling.middle).transpose() / double(at.size());
  scaling.radius = std::sqrt(moment.trace());
  const Modes3 axes = axes_of(moment);
  std::vector<Vec3> kept;
  const double least = least_extent * least_extent * axes.values[2];
  for (int k = 0; k < 3; ++k)
    if (axes.values[k] > least) kept.push_back(axes.vectors.col(k) / scaling.radius);
  if (kept.size() + 1 >= at.size()) kept.clear();
  scaling.axes.resize(3, Index(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k) scaling.axes.col(Index(k)) = kept[k];
  return scaling;
}

VectorXd polynomial(const Vec3& x, const Vec3& middle, const PlateAxes& axes) {
  VectorXd p(1 + axes.cols());
  p << 1, axes.transpose() * (x - middle);
  return p;
}

MatrixXd polynomials(const MeasuredRows& rows, const Vec3& middle, const PlateAxes& axes) {
  MatrixXd p(Index(rows.size()), 1 + axes.cols());
  for (std::size_t i = 0; i < rows.size(); ++i)
    p.row(Index(i)) = polynomial(rows.at[i], middle, axes).transpose();
  return p;
}

MatrixXd plates(const MeasuredRows& rows, double length) {
  const auto n = Index(rows.size());
  MatrixXd r = MatrixXd::Zero(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index i = j + 1; i < n; ++i)
      r(i, j) = r(j, i) = plate((rows.at[std::size_t(i)] - rows.at[std::size_t(j)]).norm() / length);
  return r;
}

Forces forces_of_rows(const MeasuredRows& rows) {
  Forces forces(Index(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) forces.row(Index(i)) = rows.force[i].transpose();
  return forces;
}

}  // namespace

std::optional<SplineLaw> likely_spline(const MeasuredRows& rows, std::optional<double> noise) {
  const Scaling scaling = scaling_of(rows.at);
  if (rows.size() < fewest_rows || !(scaling.radius > 0)) return {};
  const MatrixXd p = polynomials(rows, scaling.middle, scaling.axes);
  const Index rest = p.rows() - p.cols();
  const MatrixXd other = orthogonal_of(p).q.rightCols(rest);
  const Modes modes = modes_of(other.transpose() * plates(rows, scaling.radius) * other);
  const VectorXd squared =
      (modes.vectors.transpose() * (other.transpose() * forces_of_rows(rows))).rowwise().squaredNorm();
  const double count = 3 * double(rest);
  SplineLaw law;
  double least = std::numeric_limits<double>::infinity();
  for (double ratio = smallest_ratio; ratio < largest_ratio; ratio *= ratio_step) {
    const auto spread = modes.values.array().max(1e-14 * modes.values.maxCoeff()) + ratio;
    const double sum = std::max((squared.array() / spread).sum(), std::numeric_limits<double>::min());
    const double variance = noise && *noise > 0 ? *noise * *noise / ratio : sum / count;
    const double value = 0.5 * count * std::log(variance) + 0.5 * sum / variance + 1.5 * spread.log().sum();
    if (!(value < least)) continue;
    least = value;
    law = {.length = scaling.radius, .amplitude = std::sqrt(variance), .noise = std::sqrt(variance * ratio)};
  }
  if (!(law.amplitude > 0)) return {};
  return law;
}

ThinPlate::ThinPlate(MeasuredRows rows, const SplineLaw& law) : rows_(std::move(rows)), law_(law) {
  const Scaling scaling = scaling_of(rows_.at);
  middle_ = scaling.middle;
  axes_ = scaling.axes;
  system_ = plates(rows_, law_.length);
  const double ratio = std::max(smallest_ratio, law_.noise * law_.noise / (law_.amplitude * law_.amplitude));
  for (Index i = 0; i < system_.rows(); ++i) system_(i, i) += ratio / rows_.weight[std::size_t(i)];
  const MatrixXd p = polynomials(rows_, middle_, axes_);
  const Index own = p.cols(), rest = p.rows() - own;
  const auto [all, upper] = orthogonal_of(p);
  other_ = all.rightCols(rest).transpose();
  MatrixXd inverse = MatrixXd::Identity(own, own);
  solve_lower(upper.transpose(), inverse);
  reproducing_ = all.leftCols(own) * inverse;
  MatrixXd inner = other_ * system_ * other_.transpose();
  for (double more = 0; rest > 0; more = std::max(10 * more, 1e-14 * inner.diagonal().maxCoeff())) {
    inner.diagonal().array() += more;  // rounding may leave the matrix indefinite
    std::optional<MatrixXd> factor = cholesky_of(inner);
    if (!factor && more < 1) continue;
    lower_ = factor ? *std::move(factor) : inner;
    break;
  }
  const Forces forces = forces_of_rows(rows_);
  MatrixXd right = other_ * forces;
  solve_lower(lower_, right);
  solve_lower_transposed(lower_, right);
  weights_ = other_.transpose() * right;
  linear_ = reproducing_.transpose() * (forces - system_ * weights_);
}

GaussianProcess::Prediction ThinPlate::at(const Vec3& x) const {
  VectorXd k(Index(rows_.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i) k[Index(i)] = plate((x - rows_.at[i]).norm() / law_.length);
  const VectorXd p = polynomial(x, middle_, axes_);
  GaussianProcess::Prediction made{.force = (k.transpose() * weights_ + p.transpose() * linear_).transpose()};
  const VectorXd c = reproducing_ * p, through = system_ * c;
  MatrixXd other = other_ * (k - through);
  solve_lower(lower_, other);
  const double share = std::max(1e-15, c.dot(through) - 2 * c.dot(k) - other.squaredNorm());
  made.deviation = law_.amplitude * std::sqrt(share);
  return made;
}

}  // namespace forefeel
