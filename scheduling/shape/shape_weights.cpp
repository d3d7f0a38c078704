#include "scheduling/shape/shape_weights.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/common/enum_names.hpp"

namespace forefeel {
namespace {

using Index = Eigen::Index;

// Coordinates y = (p - x) / scale: the HIP position x of the wanted shape is the origin.
struct Scaling {
  Vec3 rest = Vec3::Zero();
  std::vector<Vec3> at;
  double scale = 1;
};

Scaling scaling_of(const Vec3& x, std::span<const Vec3> places) {
  Scaling scaling;
  scaling.scale = x.norm();
  for (const Vec3& place : places) scaling.scale = std::max(scaling.scale, (place - x).norm());
  if (!(scaling.scale > 0)) scaling.scale = 1;
  scaling.rest = -x / scaling.scale;
  for (const Vec3& place : places) scaling.at.push_back((place - x) / scaling.scale);
  return scaling;
}

double power(double r, int k) {
  return k == 1 ? r : k == 3 ? r * r * r : r * r * r * r * r;
}

// Monomials at y, and their derivatives by y_j where j >= 0.
void put_terms(const Vec3& y, int degree, int j, Eigen::Ref<Eigen::RowVectorXd> row) {
  row.setZero();
  if (j < 0) {
    row.head<4>() << 1, y[0], y[1], y[2];
    if (degree == 2)
      row.tail<6>() << y[0] * y[0], y[1] * y[1], y[2] * y[2], y[0] * y[1], y[0] * y[2], y[1] * y[2];
    return;
  }
  row[1 + j] = 1;
  if (degree < 2) return;
  row[4 + j] = 2 * y[j];
  constexpr int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int p = 0; p < 3; ++p)
    for (int side = 0; side < 2; ++side)
      if (pairs[p][side] == j) row[7 + p] = y[pairs[p][1 - side]];
}

// Rows: the values at the states, at rest, the three derivatives at rest, the polynomials.
struct System {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

System system_of(const Scaling& scaling, int k, int degree) {
  const auto n = static_cast<Index>(scaling.at.size());
  const Index values = n + 1, terms = degree == 2 ? 10 : 4, size = values + 3 + terms;
  const auto place = [&](Index i) { return i < n ? scaling.at[static_cast<std::size_t>(i)] : scaling.rest; };
  System s{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  Eigen::RowVectorXd row(terms);
  for (Index i = 0; i < values; ++i) {
    const Vec3 y = place(i);
    for (Index j = 0; j < values; ++j) s.matrix(i, j) = power((y - place(j)).norm(), k);
    const Vec3 from_rest = y - scaling.rest;
    const Vec3 slope = -k * power(from_rest.norm(), k - 2) * from_rest;
    s.matrix.block<1, 3>(i, values) = slope.transpose();
    s.matrix.block<3, 1>(values, i) = slope;
    s.right[i] = power(y.norm(), k);
    put_terms(y, degree, -1, row);
    s.matrix.row(i).tail(terms) = row;
  }
  s.right.segment<3>(values) = k * power(scaling.rest.norm(), k - 2) * scaling.rest;
  for (int j = 0; j < 3; ++j) {
    put_terms(scaling.rest, degree, j, row);
    s.matrix.row(values + j).tail(terms) = row;
  }
  s.matrix.bottomRows(terms) = s.matrix.rightCols(terms).transpose();
  s.right[values + 3] = 1;  // p(x): only the constant is not zero at the origin
  return s;
}

std::optional<ShapeWeights> interpolate(const Scaling& scaling, ShapeOrder order) {
  const auto n = static_cast<Index>(scaling.at.size());
  const bool quintic = order == ShapeOrder::quintic;
  const System s = system_of(scaling, quintic ? 5 : 3, quintic ? 2 : 1);
  const Eigen::FullPivLU<Eigen::MatrixXd> factor(s.matrix);
  if (factor.rank() < s.matrix.rows()) return {};
  Eigen::VectorXd solution = factor.solve(s.right);
  solution += factor.solve(s.right - s.matrix * solution);
  if (!solution.allFinite() || (s.right - s.matrix * solution).cwiseAbs().maxCoeff() > 1e-10) return {};
  if (solution.head(n + 1).cwiseAbs().sum() > most_weight) return {};
  ShapeWeights weights{.of_states = std::vector<double>(solution.data(), solution.data() + n),
                       .of_slope = scaling.scale * solution.segment<3>(n + 1),
                       .order = order};
  return weights;
}

}  // namespace

std::string_view name(ShapeOrder order) {
  return name_in<ShapeOrder::quintic>({"slope", "cubic", "quintic"}, order);
}

ShapeWeights shape_weights(const Vec3& x, std::span<const Vec3> places) {
  const Scaling scaling = scaling_of(x, places);
  if (places.size() >= 6)  // with rest and its slope, ten conditions
    if (auto weights = interpolate(scaling, ShapeOrder::quintic)) return *weights;
  if (!places.empty())
    if (auto weights = interpolate(scaling, ShapeOrder::cubic)) return *weights;
  ShapeWeights weights{.of_states = std::vector<double>(places.size(), 0.0), .of_slope = x};
  const auto nearest =
      std::ranges::min_element(places, {}, [&](const Vec3& place) { return (place - x).squaredNorm(); });
  if (nearest == places.end() || x.squaredNorm() <= (*nearest - x).squaredNorm()) return weights;
  weights.of_states[static_cast<std::size_t>(nearest - places.begin())] = 1;
  weights.of_slope = x - *nearest;
  return weights;
}

}  // namespace forefeel
