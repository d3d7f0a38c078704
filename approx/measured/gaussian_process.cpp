#include "approx/measured/gaussian_process.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace forefeel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Forces = Eigen::Matrix<double, Eigen::Dynamic, 3>;

constexpr double unlikely = std::numeric_limits<double>::infinity();
constexpr double almost_exact = 1e-9;  // noise of exact forces, in their root mean square
constexpr double least_noise_ratio = 1e-12, most_ratio = 1e3;  // (sigma / a)^2
constexpr int most_steps = 45;                                 // of the simplex

double correlation(double t, Smoothness smoothness) {
  if (smoothness == Smoothness::gaussian) return std::exp(-0.5 * t * t);
  const double s = std::sqrt(smoothness == Smoothness::matern52 ? 5.0 : 3.0) * t;
  return (smoothness == Smoothness::matern52 ? 1 + s + s * s / 3 : 1 + s) * std::exp(-s);
}

MatrixXd squared_distances(const std::vector<Vec3>& at) {
  MatrixXd squared(Index(at.size()), Index(at.size()));
  for (std::size_t j = 0; j < at.size(); ++j)
    for (std::size_t i = j; i < at.size(); ++i) squared(Index(i), Index(j)) = (at[i] - at[j]).squaredNorm();
  return squared;
}

// Lower triangle of R + D.
MatrixXd system_of(const MatrixXd& squared, const std::vector<double>& weight, Smoothness smoothness,
                   double length, double ratio) {
  MatrixXd system(squared.rows(), squared.cols());
  for (Index j = 0; j < squared.cols(); ++j) {
    for (Index i = j; i < squared.rows(); ++i)
      system(i, j) = correlation(std::sqrt(squared(i, j)) / length, smoothness);
    system(j, j) += ratio / weight[std::size_t(j)];
  }
  return system;
}

Forces forces_of(const MeasuredRows& rows) {
  Forces forces(Index(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) forces.row(Index(i)) = rows.force[i].transpose();
  return forces;
}

// The restricted likelihood as a function of log l and log (sigma / a)^2; a is the likeliest, or sigma / ratio if the
// noise is known.
class Likelihood {
 public:
  Likelihood(const MeasuredRows& rows, Smoothness smoothness, std::optional<double> noise)
      : squared_(squared_distances(rows.at)),
        forces_(forces_of(rows)),
        weight_(rows.weight),
        smoothness_(smoothness),
        noise_(noise) {
    // Exact forces: as nearly as rounding allows.
    if (noise_ && *noise_ == 0) noise_ = almost_exact * forces_.norm() / std::sqrt(double(forces_.size()));
  }

  struct Found {
    double value = unlikely;
    FieldLaw law = {};
  };
  Found at(double log_length, double log_ratio) const {
    const double length = std::exp(log_length);
    const double ratio = std::clamp(std::exp(log_ratio), least_noise_ratio, most_ratio);
    const Eigen::LLT<MatrixXd> factor(system_of(squared_, weight_, smoothness_, length, ratio));
    if (factor.info() != Eigen::Success) return {};
    const auto diagonal = factor.matrixLLT().diagonal().array();
    if (!(diagonal.minCoeff() > 0)) return {};
    Forces right = forces_;
    VectorXd ones = VectorXd::Ones(right.rows());
    factor.matrixL().solveInPlace(right);
    factor.matrixL().solveInPlace(ones);
    const double precision = ones.squaredNorm();
    right -= ones * (ones.transpose() * right) / precision;
    const double count = 3 * (double(right.rows()) - 1);
    const double sum = std::max(right.squaredNorm(), std::numeric_limits<double>::min());
    const double variance = noise_ && *noise_ > 0 ? *noise_ * *noise_ / ratio : sum / count;
    const double value = 0.5 * count * std::log(variance) + 0.5 * sum / variance + 3 * diagonal.log().sum() +
                         1.5 * std::log(precision);
    return {value,
            {.smoothness = smoothness_,
             .length = length,
             .amplitude = std::sqrt(variance),
             .noise = std::sqrt(variance * ratio)}};
  }

 private:
  MatrixXd squared_;
  Forces forces_;
  std::vector<double> weight_;
  Smoothness smoothness_;
  std::optional<double> noise_;
};

using LogLaw = std::array<double, 2>;
struct Corner {
  LogLaw at;
  double value;
};

// Nelder, Mead 1965, from three corners; returns the best place.
template <class Function>
LogLaw least(std::array<Corner, 3> simplex, int steps, const Function& value_at) {
  const auto along = [](const LogLaw& a, const LogLaw& b, double t) {
    return LogLaw{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
  };
  for (int step = 0; step < steps; ++step) {
    std::ranges::stable_sort(simplex, {}, &Corner::value);
    if (simplex[2].value - simplex[0].value < 1e-3) break;
    const LogLaw middle = along(simplex[0].at, simplex[1].at, 0.5);
    const auto tried = [&](double t) {
      const LogLaw at = along(middle, simplex[2].at, t);
      return Corner{at, value_at(at)};
    };
    const Corner reflected = tried(-1);
    if (reflected.value < simplex[0].value) {
      const Corner further = tried(-2);
      simplex[2] = further.value < reflected.value ? further : reflected;
    } else if (reflected.value < simplex[1].value) {
      simplex[2] = reflected;
    } else {
      const Corner nearer = tried(reflected.value < simplex[2].value ? -0.5 : 0.5);
      if (nearer.value < std::min(reflected.value, simplex[2].value)) {
        simplex[2] = nearer;
      } else {
        for (std::size_t k = 1; k < 3; ++k) {
          simplex[k].at = along(simplex[0].at, simplex[k].at, 0.5);
          simplex[k].value = value_at(simplex[k].at);
        }
      }
    }
  }
  return std::ranges::min_element(simplex, {}, &Corner::value)->at;
}

double radius_of(const std::vector<Vec3>& at) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : at) middle += x / double(at.size());
  double squared = 0;
  for (const Vec3& x : at) squared += (x - middle).squaredNorm() / double(at.size());
  return std::sqrt(squared);
}

double squared_of(double x) {
  return x * x;
}

// Where the law is sought.
class Range {
 public:
  explicit Range(double radius, double longest = 100)
      : shortest_(std::log(1e-3 * radius)), longest_(std::log(longest * radius)) {}
  double longest() const { return longest_; }
  bool holds(const LogLaw& p) const {
    return p[0] >= shortest_ && p[0] <= longest_ && p[1] >= std::log(least_noise_ratio) - 1e-9 &&
           p[1] <= std::log(most_ratio);
  }

 private:
  double shortest_, longest_;
};

// size: of the first simplex.
std::optional<LikelyLaw> searched(const Corner& start, double size, int steps_wanted, const Range& range,
                                  const Likelihood& likelihood) {
  LogLaw best = start.at;
  if (steps_wanted > 0) {
    const auto value_at = [&](const LogLaw& p) {
      return range.holds(p) ? likelihood.at(p[0], p[1]).value : unlikely;
    };
    std::array<Corner, 3> simplex{start, start, start};
    simplex[1].at[0] += 0.7 * size;
    if (!range.holds(simplex[1].at)) simplex[1].at[0] -= 1.4 * size;
    simplex[2].at[1] += 2 * size;
    if (!range.holds(simplex[2].at)) simplex[2].at[1] -= 4 * size;
    for (std::size_t k = 1; k < 3; ++k) simplex[k].value = value_at(simplex[k].at);
    best = least(simplex, steps_wanted, value_at);
  }
  const Likelihood::Found found = likelihood.at(best[0], best[1]);
  if (!(found.value < unlikely)) return {};
  return LikelyLaw{found.law, found.value};
}

// Of each group, from the precision matrix Q of the rows and Q F. Empty if rounding hides a group in the others.
std::vector<double> scores_of(const MatrixXd& precision, const Forces& weights, const Grouping& grouping) {
  std::vector<std::vector<Index>> members(std::ranges::max(grouping) + 1);
  for (std::size_t i = 0; i < grouping.size(); ++i) members[grouping[i]].push_back(Index(i));
  std::vector<double> missed, spread;  // of each group: means of |e|^2 / v and of log v
  double mean = 0;                     // of |e|^2 / v
  for (const std::vector<Index>& own : members) {
    const Eigen::LLT<MatrixXd> block(MatrixXd(precision(own, own)));
    if (block.info() != Eigen::Success) return {};
    const auto count = Index(own.size());
    const MatrixXd variance = block.solve(MatrixXd::Identity(count, count));
    const Forces error = block.solve(Forces(weights(own, Eigen::all)));
    const auto v = variance.diagonal().array();
    missed.push_back((error.rowwise().squaredNorm().array() / v).mean());
    spread.push_back(v.log().mean());
    mean += missed.back() * double(count) / double(grouping.size());
  }
  const double c = std::max(mean / 3, std::numeric_limits<double>::min());
  std::vector<double> scores;
  for (std::size_t g = 0; g < missed.size(); ++g)
    scores.push_back(0.5 * missed[g] / c + 1.5 * (std::log(c) + spread[g]));
  return scores;
}

}  // namespace

std::optional<LikelyLaw> likely_law(const MeasuredRows& rows, Smoothness smoothness,
                                    std::optional<double> noise) {
  const double radius = radius_of(rows.at);
  if (rows.size() < 4 || !(radius > 0)) return {};
  const Likelihood likelihood(rows, smoothness, noise);
  const Range range(radius);
  const auto value_at = [&](const LogLaw& p) {
    return range.holds(p) ? likelihood.at(p[0], p[1]).value : unlikely;
  };
  Corner start{.at = {}, .value = unlikely};
  for (const double length : {0.15, 0.5, 1.5, 5.0})
    for (const double ratio : {1e-10, 1e-6, 1e-3, 1e-1}) {
      const LogLaw at{std::log(length * radius), std::log(ratio)};
      if (const double value = value_at(at); value < start.value) start = {at, value};
    }
  if (!(start.value < unlikely)) return {};
  return searched(start, 1, most_steps, range, likelihood);
}

std::optional<LikelyLaw> improved_law(const MeasuredRows& rows, const FieldLaw& law,
                                      const LawSearch& search) {
  const double radius = radius_of(rows.at);
  if (rows.size() < 4 || !(radius > 0)) return {};
  const Likelihood likelihood(rows, law.smoothness, search.noise);
  const Range range(radius, search.longest);
  const LogLaw at{std::min(std::log(law.length), range.longest()),
                  std::log(std::max(least_noise_ratio, squared_of(law.noise / law.amplitude)))};
  return searched({at, likelihood.at(at[0], at[1]).value}, 0.5, search.steps, range, likelihood);
}

std::vector<std::vector<double>> left_out_scores(const MeasuredRows& rows, const FieldLaw& law,
                                                 std::span<const Grouping> groupings) {
  const double ratio = std::clamp(squared_of(law.noise / law.amplitude), least_noise_ratio, most_ratio);
  const Eigen::LLT<MatrixXd> factor(
      system_of(squared_distances(rows.at), rows.weight, law.smoothness, law.length, ratio));
  if (factor.info() != Eigen::Success) return {};
  MatrixXd precision = factor.solve(MatrixXd::Identity(Index(rows.size()), Index(rows.size())));
  const VectorXd ones = precision.rowwise().sum();
  precision -= ones * ones.transpose() / ones.sum();
  const Forces weights = precision * forces_of(rows);
  std::vector<std::vector<double>> scores;
  for (const Grouping& grouping : groupings)
    scores.push_back(
        scores_of(precision / squared_of(law.amplitude), weights / squared_of(law.amplitude), grouping));
  if (std::ranges::any_of(scores, &std::vector<double>::empty)) return {};
  return scores;
}

GaussianProcess::GaussianProcess(MeasuredRows rows, const FieldLaw& law) : rows_(std::move(rows)), law_(law) {
  const MatrixXd squared = squared_distances(rows_.at);
  double ratio =
      std::max(least_noise_ratio, law.noise * law.noise / std::max(law.amplitude * law.amplitude, 1e-300));
  for (;; ratio *= 10) {  // rounding may leave the matrix indefinite
    const Eigen::LLT<MatrixXd> factor(system_of(squared, rows_.weight, law_.smoothness, law_.length, ratio));
    if (factor.info() != Eigen::Success && ratio < most_ratio) continue;
    lower_ = factor.matrixLLT();
    break;
  }
  const auto solve = [&](auto right) {
    lower_.triangularView<Eigen::Lower>().solveInPlace(right);
    lower_.triangularView<Eigen::Lower>().adjoint().solveInPlace(right);
    return right;
  };
  ones_ = solve(VectorXd(VectorXd::Ones(lower_.rows())));
  Forces forces = forces_of(rows_);
  mean_ = ones_.transpose() * forces / ones_.sum();
  forces.rowwise() -= mean_;
  weights_ = solve(forces);
}

VectorXd GaussianProcess::correlations(const Vec3& x) const {
  VectorXd k(Index(rows_.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i)
    k[Index(i)] = correlation((x - rows_.at[i]).norm() / law_.length, law_.smoothness);
  return k;
}

Vec3 GaussianProcess::force(const Vec3& x) const {
  return (mean_ + correlations(x).transpose() * weights_).transpose();
}

GaussianProcess::Prediction GaussianProcess::at(const Vec3& x) const {
  VectorXd k = correlations(x);
  Prediction made{.force = (mean_ + k.transpose() * weights_).transpose()};
  const double rest = 1 - ones_.dot(k);
  lower_.triangularView<Eigen::Lower>().solveInPlace(k);
  const double share = std::max(1e-15, 1 - k.squaredNorm() + rest * rest / ones_.sum());
  made.deviation = law_.amplitude * std::sqrt(share);
  return made;
}

}  // namespace forefeel
