#include "solver/jet/field_patches.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "solver/jet/site_turns.hpp"

namespace forefeel {
namespace {

constexpr int most_patch_degree = 4, most_places = 15;
constexpr int quantities = 6 + 3 + static_cast<int>(jet_size);  // K, the normal, degrees 3 to 5

using Quantities = Eigen::Matrix<double, quantities, 1>;

// Lagrange's shape functions and their derivatives by the barycentric coordinates b: products of
// L_a(t) = prod_{m < a} (n t - m) / (m + 1), n the degree. Place (i, j) has b = (n - i - j, i, j) / n.
struct Shape {
  std::array<double, most_places> value{};
  std::array<Vec3, most_places> slope{};
};
Shape shape_at(const Vec3& b, int degree) {
  std::array<std::array<double, most_patch_degree + 1>, 3> part{}, by{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = degree * b[static_cast<int>(i)];
    part[i][0] = 1;
    for (std::size_t a = 0; a < static_cast<std::size_t>(degree); ++a) {
      const double m = static_cast<double>(a);
      part[i][a + 1] = part[i][a] * (t - m) / (m + 1);
      by[i][a + 1] = (by[i][a] * (t - m) + degree * part[i][a]) / (m + 1);
    }
  }
  Shape shape;
  std::size_t k = 0;
  const auto n = static_cast<std::size_t>(degree);
  for (std::size_t i = 0; i <= n; ++i)
    for (std::size_t j = 0; i + j <= n; ++j, ++k) {
      const double a = part[0][n - i - j], c = part[1][i], d = part[2][j];
      shape.value[k] = a * c * d;
      shape.slope[k] = {by[0][n - i - j] * c * d, a * by[1][i] * d, a * c * by[2][j]};
    }
  return shape;
}

// One of the equal triangles that a facet is split in, and where in it a place is: barycentric coordinates by its
// corners, of which the first lies at (i, j) in parts of the facet's second and third coordinates. sign: -1 where it
// lies upside down.
struct SubFacet {
  int i = 0, j = 0;
  double sign = 1;
  Vec3 share = Vec3::Zero();
};
SubFacet sub_facet_at(const Vec3& b, int parts) {
  const double u = parts * b[1], v = parts * b[2];
  SubFacet part;
  part.i = std::clamp(static_cast<int>(u), 0, parts - 1);
  part.j = std::clamp(static_cast<int>(v), 0, parts - 1 - part.i);
  const double du = u - part.i, dv = v - part.j;
  if (du + dv <= 1 || part.i + part.j == parts - 1) {
    part.share = {1 - du - dv, du, dv};
    return part;
  }
  ++part.i, ++part.j, part.sign = -1;
  part.share = {du + dv - 1, 1 - du, 1 - dv};
  return part;
}

// Of the place (i, j) in degree-ths of the part: its number among the facet's.
std::size_t number_of(const SubFacet& part, int i, int j, int degree, int parts) {
  const int sign = part.sign > 0 ? 1 : -1, row = part.i * degree + sign * i,
            column = part.j * degree + sign * j, all = parts * degree;
  return static_cast<std::size_t>(row * (all + 1) - row * (row - 1) / 2 + column);
}

Mat3 symmetric(const double* v) {
  Mat3 m;
  m << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  return m;
}

int degree_for(const RestSites& sites) {
  double sum = 0;
  const auto count = static_cast<std::int32_t>(sites.map().facets().size());
  for (std::int32_t f = 0; f < count; ++f) {
    const auto [a, b, c] = sites.map().corners(f);
    sum += ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3;
  }
  return sum / count < 0.5 * sites.pad().radius() ? 3 : 4;
}

// A place of facets: nodes and their weights in degree-ths, ascending by node; facets that share it have one key.
using Key = std::array<std::uint32_t, 6>;
Key key_of(const Triangle& nodes, const std::array<std::uint32_t, 3>& weight) {
  std::array<std::array<std::uint32_t, 2>, 3> parts{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (weight[i] > 0) parts[count++] = {nodes[i] + 1, weight[i]};
  std::sort(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(count));
  return {parts[0][0], parts[0][1], parts[1][0], parts[1][1], parts[2][0], parts[2][1]};
}

Quantities quantities_at(const SiteField& field, const SurfacePlace& place) {
  const SiteModel model = field.at(place, false);
  const Mat3& k = model.rest().stiffness;
  Quantities q;
  q << k(0, 0), k(0, 1), k(0, 2), k(1, 1), k(1, 2), k(2, 2), model.rest().normal, model.polynomial();
  return q;
}

}  // namespace

// Places of all facets that can move: a lattice of `parts` times degree steps along each edge.
void FieldPatches::place_points(int parts) {
  const SurfaceMap& map = field_->rest().map();
  const auto n = static_cast<std::uint32_t>(parts * degree_);
  parts_ = parts;
  std::map<Key, std::int32_t> numbers;
  places_.clear(), points_.clear();
  first_.assign(map.facets().size(), -1);
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    if (map.facets()[f].clamped) continue;
    const auto facet = static_cast<std::int32_t>(f);
    const auto [a, b, c] = map.corners(facet);
    first_[f] = static_cast<std::int64_t>(points_.size());
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; i + j <= n; ++j) {
        const auto [at, is_new] = numbers.try_emplace(key_of(map.facets()[f].corners, {n - i - j, i, j}),
                                                      static_cast<std::int32_t>(places_.size()));
        if (is_new)
          places_.push_back(map.smooth().is_flat(facet)
                                ? SurfacePlace{facet, ((n - i - j) * a + i * b + j * c) / n}
                                : map.place(facet, Vec3(n - i - j, i, j) / n));
        points_.push_back(at->second);
      }
  }
}

double FieldPatches::measured_error() const {
  constexpr int tried = 40;
  std::mt19937_64 random(1);
  double square = 0;
  for (int i = 0; i < tried; ++i) {
    const SurfacePlace place = field_->rest().map().random(random);
    SiteModel model;
    fill(place, false, model);
    const Mat3 exact = field_->rest().at(place, false).stiffness;
    square += (model.rest().stiffness - exact).squaredNorm() / exact.squaredNorm();
  }
  return std::sqrt(square / tried);
}

FieldPatches::FieldPatches(std::shared_ptr<const SiteField> field, std::span<const double> known,
                           const std::function<void(double)>& progress, const std::stop_token& stop)
    : field_(std::move(field)), degree_(degree_for(field_->rest())) {
  constexpr int most_parts = 4;
  constexpr std::size_t most_points = 60'000;
  constexpr double enough = 0.002;
  const auto doubles = [&] { return places_.size() * static_cast<std::size_t>(quantities) + 1; };
  for (int parts = 1; parts <= most_parts && !known.empty(); parts *= 2) {
    place_points(parts);
    if (known.size() != doubles()) continue;
    values_.assign(known.begin(), known.end());
    return;
  }
  for (int parts = 1;; parts *= 2) {
    place_points(parts);
    values_.assign(doubles(), 0);
    std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 8) num_threads(field_->options().threads)
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (stop.stop_requested()) continue;
      Eigen::Map<Quantities>(values_.data() + i * static_cast<std::size_t>(quantities)) =
          quantities_at(*field_, places_[i]);
#pragma omp critical
      if (++done % 64 == 0 && progress)
        progress(static_cast<double>(done) / static_cast<double>(places_.size()));
    }
    if (done < places_.size()) {
      first_.assign(first_.size(), -1), values_.clear();
      return;
    }
    values_.back() = measured_error();
    if (2 * parts > most_parts || 4 * places_.size() > most_points || error() <= enough) return;
  }
}

bool FieldPatches::is_on_edge(const SurfacePlace& place) const {
  constexpr double near = 1e-5;
  const Vec3 in_parts = parts_ * field_->rest().map().barycentric(place);
  return (in_parts - in_parts.array().round().matrix()).cwiseAbs().minCoeff() < near;
}

void FieldPatches::fill(const SurfacePlace& place, bool root, SiteModel& model) const {
  const SurfaceMap& map = field_->rest().map();
  const SubFacet part = sub_facet_at(map.barycentric(place), parts_);
  const Shape shape = shape_at(part.share, degree_);
  std::array<Vec3, 3> by = map.barycentric_slopes(place);
  for (Vec3& row : by) row *= part.sign * parts_;
  Quantities value = Quantities::Zero();
  Eigen::Matrix<double, quantities, 3> slope = Eigen::Matrix<double, quantities, 3>::Zero();
  const auto first = static_cast<std::size_t>(first_[static_cast<std::size_t>(place.facet)]);
  std::size_t k = 0;
  for (int i = 0; i <= degree_; ++i)
    for (int j = 0; i + j <= degree_; ++j, ++k) {
      const std::size_t number = number_of(part, i, j, degree_, parts_);
      const Eigen::Map<const Quantities> at(values_.data() +
                                            static_cast<std::size_t>(points_[first + number]) *
                                                static_cast<std::size_t>(quantities));
      const Vec3 in_space = shape.slope[k][0] * by[0] + shape.slope[k][1] * by[1] + shape.slope[k][2] * by[2];
      value += shape.value[k] * at;
      for (int axis = 0; axis < 3; ++axis) slope.col(axis) += in_space[axis] * at;
    }
  SiteRest rest;
  rest.stiffness = symmetric(value.data());
  for (int axis = 0; axis < 3; ++axis)
    rest.stiffness_by[static_cast<std::size_t>(axis)] = symmetric(slope.col(axis).data());
  const Vec3 sum = value.segment<3>(6);
  const double length = sum.norm();
  if (length > 0) rest.normal = sum / length;
  if (length > 0)
    rest.normal_by =
        (Mat3::Identity() - rest.normal * rest.normal.transpose()) / length * slope.middleRows<3>(6);
  model.take(rest, value.tail<static_cast<int>(jet_size)>(), slope.bottomRows<static_cast<int>(jet_size)>(),
             root, field_->options().theta);
}

}  // namespace forefeel
