#include "approx/error/power_function.hpp"

#include <cmath>
#include <limits>

#include "approx/model/polynomial.hpp"
#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

// Functional 0: the value; 1 to 3: a derivative, applied to phi(|a - b|) = |a - b|^k.
double pair(int k, const Vec3& a, int da, const Vec3& b, int db) {
  const Vec3 d = a - b;
  const double r = d.norm();
  if (da == 0 && db == 0) return std::pow(r, k);
  if (r == 0) return 0;  // k >= 3: derivatives vanish there
  const double first = k * std::pow(r, k - 2);
  if (da == 0) return -first * d[db - 1];
  if (db == 0) return first * d[da - 1];
  const double second = k * (k - 2) * std::pow(r, k - 4);
  return -(da == db ? first : 0) - second * d[da - 1] * d[db - 1];
}

// Monomials 1 x y z xx yy zz xy xz yz, or a derivative of them.
double term(int t, const Vec3& y, int derivative) {
  static constexpr int exponent[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                          {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  double value = 1;
  for (int d = 0; d < 3; ++d) {
    const int e = exponent[t][d];
    if (derivative == d + 1)
      value *= e == 0 ? 0.0 : e == 1 ? 1.0 : 2 * y[d];
    else
      for (int i = 0; i < e; ++i) value *= y[d];
  }
  return value;
}

}  // namespace

double power_function(std::span<const State> states, const ModelOptions& options, const Vec3& x) {
  const int k = detail::power_of(options.kernel);
  const int terms = k == 5 ? 10 : 4, per_state = options.data == Data::force_and_stiffness ? 4 : 1;
  const auto n = static_cast<Eigen::Index>(states.size()), rows = n * per_state;
  if (n == 0) return std::numeric_limits<double>::infinity();
  Vec3 centre = Vec3::Zero();
  double scale = 0;
  for (const State& s : states) centre += s.at / static_cast<double>(n);
  for (const State& s : states) scale = std::max(scale, (s.at - centre).norm());
  if (scale == 0) return std::numeric_limits<double>::infinity();
  const auto scaled = [&](const Vec3& at) { return Vec3((at - centre) / scale); };
  const auto at = [&](Eigen::Index row) {
    return scaled(states[static_cast<std::size_t>(row / per_state)].at);
  };

  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(rows + terms, rows + terms);
  Eigen::VectorXd right(rows + terms);
  const Vec3 y = scaled(x);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Vec3 a = at(i);
    const int da = static_cast<int>(i % per_state);
    for (Eigen::Index j = 0; j < rows; ++j)
      system(i, j) = pair(k, a, da, at(j), static_cast<int>(j % per_state));
    for (int t = 0; t < terms; ++t) system(i, rows + t) = system(rows + t, i) = term(t, a, da);
    right[i] = pair(k, a, da, y, 0);
  }
  for (int t = 0; t < terms; ++t) right[rows + t] = term(t, y, 0);
  if (rank_of(system.topRightCorner(rows, terms)) < terms) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd solution = solved(system, right);
  const auto u = solution.head(rows);
  // By the first block row A u = k - Q v, so that u^T A u = u . k - q . v.
  const double squared = -(u.dot(right.head(rows)) + solution.tail(terms).dot(right.tail(terms)));
  const double sign = k == 3 ? 1 : -1;
  if (!std::isfinite(squared)) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0.0, sign * squared)) * std::pow(scale, 0.5 * k);
}

}  // namespace forefeel
