#include "approx/error/leave_one_out.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/model/polynomial.hpp"
#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_sets = 12;

struct Level {
  int power, degree;
  bool hermite;
};

// A functional: the value at a point, or (axis 0 to 2) the derivative there.
struct Row {
  Vec3 at;
  int axis;
  Index state;
};

double kernel(const Row& a, const Row& b, int k) {
  const Vec3 d = a.at - b.at;
  const double r = d.norm();
  if (a.axis < 0 && b.axis < 0) return std::pow(r, k);
  const double first = r > 0 || k > 2 ? k * std::pow(r, k - 2) : 0;
  if (a.axis < 0) return -first * d[b.axis];
  if (b.axis < 0) return first * d[a.axis];
  const double second = r > 0 ? k * (k - 2) * std::pow(r, k - 4) : 0;
  return -(a.axis == b.axis ? first : 0) - second * d[a.axis] * d[b.axis];
}

Eigen::RowVectorXd monomials(const Row& row, int degree) {
  const Vec3& x = row.at;
  Eigen::RowVectorXd p(Index(detail::polynomial_terms(degree)));
  p.setZero();
  if (row.axis < 0) {
    p[0] = 1;
    if (degree >= 1) p.segment<3>(1) = x.transpose();
    if (degree == 2)
      p.tail<6>() << x[0] * x[0], x[1] * x[1], x[2] * x[2], x[0] * x[1], x[0] * x[2], x[1] * x[2];
    return p;
  }
  if (degree >= 1) p[1 + row.axis] = 1;
  if (degree == 2) {
    const int other[3][2] = {
        {7, 8}, {7, 9}, {8, 9}};  // of xy, xz, yz those with this axis, lower partner first
    const int partner[3][2] = {{1, 2}, {0, 2}, {0, 1}};
    p[4 + row.axis] = 2 * x[row.axis];
    for (int t = 0; t < 2; ++t) p[other[row.axis][t]] = x[partner[row.axis][t]];
  }
  return p;
}

// The system of one set, diagonalised on the null space of P^T.
class Crossed {
 public:
  Crossed(std::span<const State* const> states, const ModelOptions& options) : states_(states) {
    Vec3 centre = Vec3::Zero();
    for (const State* s : states) centre += s->at / double(states.size());
    double radius = 0;
    for (const State* s : states) radius = std::max(radius, (s->at - centre).norm());
    if (!(radius > 0)) return;
    Level level{detail::power_of(options.kernel), options.kernel == Kernel::quintic ? 2 : 1,
                options.data == Data::force_and_stiffness};
    for (;; --level.degree) {  // steps down as RbfFit does
      if (level.degree < 2) level.power = level.degree == 0 ? 1 : std::min(level.power, 3);
      level.hermite = level.hermite && level.degree > 0;
      set_rows(centre, radius, level.hermite);
      MatrixXd p(Index(rows_.size()), Index(detail::polynomial_terms(level.degree)));
      for (Index i = 0; i < p.rows(); ++i) p.row(i) = monomials(rows_[std::size_t(i)], level.degree);
      const RankedOrthogonal qr = ranked_orthogonal_of(p, 1e-6);
      if (qr.rank == p.cols() && p.rows() > p.cols()) {
        diagonalise(qr, level.power);
        return;
      }
      if (level.degree == 0) return;
    }
  }

  // Errors at every state; NaN if the others do not determine a model.
  std::vector<Vec3> misses(double ridge) const {
    std::vector<Vec3> out(states_.size(), Vec3::Constant(unknown));
    if (values_.size() == 0) return out;
    // K is positive definite there, up to rounding.
    const VectorXd inverse = (values_.array().max(1e-15 * values_.maxCoeff()) + ridge).inverse();
    const MatrixXd lambda = vectors_ * (inverse.asDiagonal() * (vectors_.transpose() * right_));
    for (std::size_t begin = 0; begin < rows_.size();) {
      std::size_t end = begin;
      while (end < rows_.size() && rows_[end].state == rows_[begin].state) ++end;
      const auto v = vectors_.middleRows(Index(begin), Index(end - begin));
      const MatrixXd block = v * inverse.asDiagonal() * v.transpose();
      const Eigen::LDLT<MatrixXd> factor(block);
      const VectorXd pivots = factor.vectorD();
      if (pivots.minCoeff() > 1e-13 * pivots.maxCoeff())
        out[std::size_t(rows_[begin].state)] =
            factor.solve(lambda.middleRows(Index(begin), Index(end - begin))).row(0).transpose();
      begin = end;
    }
    return out;
  }

 private:
  void set_rows(const Vec3& centre, double radius, bool hermite) {
    rows_.clear();
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const int last = hermite && states_[i]->has_stiffness() ? 3 : 0;
      for (int axis = -1; axis < last; ++axis)
        rows_.push_back({(states_[i]->at - centre) / radius, axis, Index(i)});
    }
    right_.resize(Index(rows_.size()), 3);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const State& s = *states_[std::size_t(rows_[r].state)];
      if (rows_[r].axis < 0)
        right_.row(Index(r)) = s.force.transpose();
      else
        right_.row(Index(r)) = -radius * s.stiffness.col(rows_[r].axis).transpose();
    }
  }

  void diagonalise(const RankedOrthogonal& qr, int power) {
    const Index m = Index(rows_.size()), q = qr.rank;
    MatrixXd k(m, m);
    for (Index i = 0; i < m; ++i)
      for (Index j = 0; j <= i; ++j)
        k(i, j) = k(j, i) =
            (power == 3 ? 1 : -1) * kernel(rows_[std::size_t(i)], rows_[std::size_t(j)], power);
    const MatrixXd z = qr.q.rightCols(m - q);
    const Modes modes = modes_of(z.transpose() * k * z);
    values_ = modes.values;
    vectors_ = z * modes.vectors;
  }

  std::span<const State* const> states_;
  std::vector<Row> rows_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> right_;
  VectorXd values_;
  MatrixXd vectors_;
};

}  // namespace

std::vector<Vec3> leave_one_out(std::span<const State> states, const ModelOptions& options) {
  std::vector<const State*> usable;
  for (const State& s : states)
    if (s.usable()) usable.push_back(&s);
  return Crossed(usable, options).misses(options.ridge);
}

RidgeChoice choose_ridge(const StateSpace& space, const ModelOptions& options) {
  if (space.empty()) return {};
  std::vector<double> ridges{0};
  for (int half = -24; half <= 2; ++half) ridges.push_back(std::pow(10.0, 0.5 * half));
  std::vector<double> missed(ridges.size(), 0);
  double count = 0;
  const std::size_t n = std::min(options.neighbours, space.size());
  const std::size_t sets = n == space.size() ? 1 : std::min(most_sets, space.size());
  std::vector<StateId> ids;
  for (std::size_t set = 0; set < sets; ++set) {
    const StateId middle{static_cast<std::uint32_t>(set * space.size() / std::max<std::size_t>(sets, 1))};
    space.nearest(space[middle].at, n, ids);
    std::vector<const State*> states;
    for (const StateId id : ids) states.push_back(&space[id]);
    const Crossed crossed(states, options);
    for (std::size_t r = 0; r < ridges.size(); ++r)
      for (const Vec3& miss : crossed.misses(ridges[r]))
        if (miss.allFinite()) {
          missed[r] += miss.squaredNorm();
          count += r == 0 ? 1 : 0;
        }
  }
  if (count == 0) return {};
  const auto best = static_cast<std::size_t>(std::ranges::min_element(missed) - missed.begin());
  return {ridges[best], std::sqrt(missed[best] / count), std::sqrt(missed[0] / count)};
}

double power_function(std::span<const State> states, const ModelOptions& options, const Vec3& x) {
  const int k = detail::power_of(options.kernel), degree = k == 5 ? 2 : 1;
  const int terms = k == 5 ? 10 : 4, per_state = options.data == Data::force_and_stiffness ? 4 : 1;
  const auto n = static_cast<Index>(states.size()), rows = n * per_state;
  if (n == 0) return std::numeric_limits<double>::infinity();
  Vec3 centre = Vec3::Zero();
  double scale = 0;
  for (const State& s : states) centre += s.at / static_cast<double>(n);
  for (const State& s : states) scale = std::max(scale, (s.at - centre).norm());
  if (scale == 0) return std::numeric_limits<double>::infinity();
  const auto row_at = [&](const Vec3& at, Index row) {
    return Row{(at - centre) / scale, static_cast<int>(row % per_state) - 1, row / per_state};
  };
  const auto row_of = [&](Index row) {
    return row_at(states[static_cast<std::size_t>(row / per_state)].at, row);
  };

  MatrixXd system = MatrixXd::Zero(rows + terms, rows + terms);
  VectorXd right(rows + terms);
  const Row value = row_at(x, 0);
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < rows; ++j) system(i, j) = kernel(row_of(i), row_of(j), k);
    system.row(i).tail(terms) = monomials(row_of(i), degree);
    right[i] = kernel(row_of(i), value, k);
  }
  system.bottomLeftCorner(terms, rows) = system.topRightCorner(rows, terms).transpose();
  right.tail(terms) = monomials(value, degree).transpose();
  if (rank_of(system.topRightCorner(rows, terms)) < terms) return std::numeric_limits<double>::infinity();
  const VectorXd solution = solved(system, right);
  const auto u = solution.head(rows);
  // By the first block row A u = k - Q v, so that u^T A u = u . k - q . v.
  const double squared = -(u.dot(right.head(rows)) + solution.tail(terms).dot(right.tail(terms)));
  const double sign = k == 3 ? 1 : -1;
  if (!std::isfinite(squared)) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0.0, sign * squared)) * std::pow(scale, 0.5 * k);
}

}  // namespace forefeel
