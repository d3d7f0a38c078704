#include "solver/jet/path_directions.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

using Matrix = Eigen::MatrixXd;

std::array<double, 3 * path_direction_count> make_directions() {
  std::array<double, 3 * path_direction_count> list{};
  std::size_t at = 0;
  const auto add = [&](double x, double y, double z) {
    for (const double value : {x, y, z}) list[at++] = value;
  };
  add(1, 0, 0), add(0, 1, 0), add(0, 0, 1);
  for (const double s : {0.6, -0.6}) {
    add(1, s, 0), add(s, 1, 0), add(1, 0, s), add(s, 0, 1), add(0, 1, s), add(0, s, 1);
  }
  const double l = 1.8, i = 1 / 1.8;
  add(l, -1, -1), add(-1, l, -1), add(-1, -1, l), add(i, 1, 1), add(1, i, 1), add(1, 1, i);
  return list;
}

// Row k: the monomials of the degree at direction k, in the order of EnergyJet::coefficients.
Matrix monomials(int degree) {
  const auto& d = path_directions();
  Matrix m(static_cast<Eigen::Index>(path_direction_count), degree == 4 ? 15 : 21);
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    Eigen::Index column = 0;
    const double* x = d.data() + 3 * k;
    for (int a = degree; a >= 0; --a)
      for (int b = degree - a; b >= 0; --b)
        m(k, column++) = std::pow(x[0], a) * std::pow(x[1], b) * std::pow(x[2], degree - a - b);
  }
  return m;
}

void set(const Matrix& inverse, std::span<const double, path_direction_count> values, double* to) {
  const Eigen::Map<const Eigen::VectorXd> v(values.data(), static_cast<Eigen::Index>(values.size()));
  Eigen::Map<Eigen::VectorXd>(to, inverse.rows()).noalias() = inverse * v;
}

// Of the values at the unit directions.
double condition_of(int degree) {
  Matrix m = monomials(degree);
  for (Eigen::Index k = 0; k < m.rows(); ++k)
    m.row(k) /= std::pow(path_lengths()[static_cast<std::size_t>(k)], degree);
  const Eigen::VectorXd squares = modes_of(m.transpose() * m).values;  // of the singular values, ascending
  return std::sqrt(squares[squares.size() - 1] / squares[0]);
}

}  // namespace

const std::array<double, 3 * path_direction_count>& path_directions() {
  static const auto list = make_directions();
  return list;
}

const std::array<double, path_direction_count>& path_lengths() {
  static const auto list = [] {
    std::array<double, path_direction_count> lengths{};
    for (std::size_t k = 0; k < path_direction_count; ++k)
      lengths[k] = Eigen::Map<const Vec3>(path_directions().data() + 3 * k).norm();
    return lengths;
  }();
  return list;
}

std::array<double, 6> pair_products(const double* d) {
  return {d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[0] * d[2], d[1] * d[2]};
}

void set_fourth(std::span<const double, path_direction_count> values, EnergyJet& jet) {
  static const Matrix inverse = pseudo_inverse(monomials(4));
  set(inverse, values, jet.coefficients.data() + 10);
}

void set_fifth(std::span<const double, path_direction_count> values, EnergyJet& jet) {
  constexpr auto count = static_cast<Eigen::Index>(path_direction_count);
  static const Matrix inverse = solved(monomials(5), Matrix::Identity(count, count));
  set(inverse, values, jet.coefficients.data() + 25);
}

double path_condition() {
  return std::max(condition_of(4), condition_of(5));
}

}  // namespace forefeel
