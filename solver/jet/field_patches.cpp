#include "solver/jet/field_patches.hpp"

#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "geometry/common/dense.hpp"
#include "solver/jet/site_turns.hpp"
#include "solver/kernels/site_sums.hpp"

namespace forefeel {
namespace {

constexpr int most_patch_degree = 4, most_places = 15;
constexpr int quantities = 6 + 3 + static_cast<int>(jet_size);  // K, the normal, degrees 3 to 5

using Quantities = Eigen::Matrix<double, quantities, 1>;

// Lagrange's shape functions and their derivatives by the barycentric coordinates b: products of
// L_a(t) = prod_{m < a} (n t - m) / (m + 1), n the degree. Place (i, j) has b = (n - i - j, i, j) / n.
struct Shape {
  static constexpr std::size_t size = most_places + 3 * most_patch_degree;  // behind the places: ramps
  std::array<double, size> value{};
  std::array<Vec3, size> slope{};
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

// Of the parts of a facet, by rows.
std::size_t part_number(const SubFacet& part, int parts) {
  const bool turned = part.sign < 0;
  const int i = turned ? part.i - 1 : part.i, j = turned ? part.j - 1 : part.j;
  return static_cast<std::size_t>(i * (2 * parts - i) + 2 * j + (turned ? 1 : 0));
}

// What makes the derivatives continuous over the edges of a part: on edge i, from corner i to the next, the functions
//   b_ik = d_i q_i / (q_0 + q_1 + q_2) t^k,  q_i = (d_j d_l)^2,  t = b_(i+1) / (b_i + b_(i+1)),  k < degree
// with d_i the distance to edge i. They vanish on all edges, and so do their derivatives, but for that across edge i,
// which is t^k.
void add_ramps(const Vec3& b, const Vec3& heights, int degree, Shape& shape) {
  std::array<double, 3> d{}, q{};
  std::array<Vec3, 3> q_by;
  double sum = 0;
  Vec3 sum_by = Vec3::Zero();
  const auto opposite = [](std::size_t edge) { return static_cast<int>((edge + 2) % 3); };
  for (std::size_t i = 0; i < 3; ++i) d[i] = heights[static_cast<int>(i)] * b[opposite(i)];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
    q[i] = d[j] * d[j] * d[l] * d[l];
    q_by[i].setZero();
    q_by[i][opposite(j)] = 2 * d[j] * d[l] * d[l] * heights[static_cast<int>(j)];
    q_by[i][opposite(l)] = 2 * d[l] * d[j] * d[j] * heights[static_cast<int>(l)];
    sum += q[i], sum_by += q_by[i];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto u = static_cast<int>(i), v = static_cast<int>((i + 1) % 3);
    const double both = b[u] + b[v];
    const bool at_corner = !(sum > 0) || !(both > 1e-12);
    const double share = at_corner ? 0 : q[i] / sum, ramp = d[i] * share, t = at_corner ? 0 : b[v] / both;
    Vec3 ramp_by = Vec3::Zero(), t_by = Vec3::Zero();
    if (!at_corner) {
      ramp_by = d[i] * (q_by[i] - share * sum_by) / sum;
      ramp_by[opposite(i)] += share * heights[u];
      t_by[v] = b[u] / (both * both), t_by[u] = -b[v] / (both * both);
    }
    double power = 1, before = 0;
    for (int k = 0; k < degree; ++k) {
      const auto at = static_cast<std::size_t>(most_places + static_cast<int>(i) * most_patch_degree + k);
      shape.value[at] = ramp * power;
      shape.slope[at] = power * ramp_by + ramp * k * before * t_by;
      before = power, power *= t;
    }
  }
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

Eigen::Map<const Quantities> row_of(const std::vector<double>& values, std::int64_t row) {
  return Eigen::Map<const Quantities>(values.data() + row * quantities);
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
    first_[f] = static_cast<std::int64_t>(points_.size());
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; i + j <= n; ++j) {
        const auto [at, is_new] = numbers.try_emplace(key_of(map.facets()[f].corners, {n - i - j, i, j}),
                                                      static_cast<std::int32_t>(places_.size()));
        if (is_new) places_.push_back(map.place(facet, Vec3(n - i - j, i, j) / n));
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
                           const std::function<void(double)>& progress, const std::stop_token& stop,
                           KeptPieces* kept)
    : field_(std::move(field)), degree_(degree_for(field_->rest())) {
  constexpr int most_parts = 4;
  constexpr std::size_t most_points = 60'000;
  constexpr double enough = 0.002;
  for (int parts = 1; parts <= most_parts && !known.empty(); parts *= 2) {
    place_points(parts);
    if (known.size() != places_.size() * static_cast<std::size_t>(quantities) + 1) continue;
    values_.assign(known.begin(), known.end());
    find_turns();
    return;
  }
  for (int parts = 1;; parts *= 2) {
    place_points(parts);
    if (!find_values(parts, progress, stop, kept)) {
      first_.assign(first_.size(), -1), values_.clear();
      return;
    }
    find_turns();
    values_.back() = measured_error();
    if (2 * parts > most_parts || 4 * places_.size() > most_points || error() <= enough) return;
  }
}

// At all places; false where it was stopped before.
bool FieldPatches::find_values(int parts, const std::function<void(double)>& progress,
                               const std::stop_token& stop, KeptPieces* kept) {
  constexpr auto width = static_cast<std::size_t>(quantities);
  values_.assign(places_.size() * width + 1, 0);
  const auto values_at = [&](std::size_t i) { return std::span(values_).subspan(i * width, width); };
  const auto piece_of = [&](std::size_t i) { return (static_cast<std::uint64_t>(parts) << 40) + i; };
  std::vector<char> made(places_.size(), 0);
  for (std::size_t i = 0; i < places_.size() && kept; ++i)
    made[i] = kept->take(piece_of(i), values_at(i)) ? 1 : 0;
  auto done = static_cast<std::size_t>(std::ranges::count(made, 1));
  const auto show = [&] {
    if (progress) progress(static_cast<double>(done) / static_cast<double>(places_.size()));
  };
  show();
#pragma omp parallel for schedule(dynamic, 8) num_threads(field_->options().threads)
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (made[i] != 0 || stop.stop_requested()) continue;
    Eigen::Map<Quantities>(values_at(i).data()) = quantities_at(*field_, places_[i]);
#pragma omp critical
    {
      if (kept) kept->keep(piece_of(i), values_at(i));
      if (++done % 64 == 0) show();
    }
  }
  return done == places_.size();
}

// Half of what the derivatives across an edge lack to be one, at as many places of it as its polynomial has terms.
void FieldPatches::find_turns() {
  const SurfaceMap& map = field_->rest().map();
  const auto terms = static_cast<std::size_t>(degree_), width = static_cast<std::size_t>(quantities);
  struct Side {
    std::size_t of;  // in edges_
    bool forward;
  };
  std::map<std::array<std::int32_t, 2>, std::vector<Side>> sides;
  std::vector<double> across;  // by side: at the places t, from the lower place to the higher one
  edges_.clear(), turns_.clear();
  first_edge_.assign(map.facets().size(), -1);
  const auto at = [&](std::size_t k) { return static_cast<double>(k) / static_cast<double>(terms - 1); };
  const auto visit = [&](std::int32_t facet, const SubFacet& part) {
    const auto first = static_cast<std::size_t>(first_[static_cast<std::size_t>(facet)]);
    const std::array<std::int32_t, 3> corner{points_[first + number_of(part, 0, 0, degree_, parts_)],
                                             points_[first + number_of(part, degree_, 0, degree_, parts_)],
                                             points_[first + number_of(part, 0, degree_, degree_, parts_)]};
    std::array<Vec3, 3> by = map.flat_slopes(facet);
    for (Vec3& row : by) row *= part.sign * parts_;
    for (std::size_t side = 0; side < 3; ++side) {
      const std::int32_t p = corner[side], q = corner[(side + 1) % 3];
      // side 01 of a part that is not turned lies on side 01 of the facet where j = 0, and so on
      const bool kept = part.sign > 0 &&
                        (side == 0   ? part.j
                         : side == 1 ? parts_ - 1 - part.i - part.j
                                     : part.i) == 0 &&
                        map.smooth().keeps(facet, side);
      if (!kept) sides[{std::min(p, q), std::max(p, q)}].push_back({edges_.size(), p < q});
      edges_.push_back(-1);
      const Vec3 inward = by[(side + 2) % 3].normalized();
      for (std::size_t k = 0; k < terms; ++k) {
        const double t = p < q ? at(k) : 1 - at(k);
        Vec3 share = Vec3::Zero();
        share[static_cast<int>(side)] = 1 - t, share[static_cast<int>((side + 1) % 3)] = t;
        const Shape shape = shape_at(share, degree_);
        Quantities sum = Quantities::Zero();
        std::size_t number = 0;
        for (int i = 0; i <= degree_; ++i)
          for (int j = 0; i + j <= degree_; ++j, ++number) {
            double slope = 0;
            for (std::size_t c = 0; c < 3; ++c)
              slope += shape.slope[number][static_cast<int>(c)] * inward.dot(by[c]);
            sum += slope * row_of(values_, points_[first + number_of(part, i, j, degree_, parts_)]);
          }
        across.insert(across.end(), sum.data(), sum.data() + width);
      }
    }
  };
  for (std::size_t f = 0; f < map.facets().size(); ++f) {
    if (first_[f] < 0) continue;
    first_edge_[f] = static_cast<std::int64_t>(edges_.size());
    for (int i = 0; i < parts_; ++i)  // as part_number
      for (int j = 0; i + j < parts_; ++j) {
        visit(static_cast<std::int32_t>(f), {.i = i, .j = j});
        if (i + j + 1 < parts_) visit(static_cast<std::int32_t>(f), {.i = i + 1, .j = j + 1, .sign = -1});
      }
  }
  Eigen::MatrixXd powers(degree_, degree_);
  for (int k = 0; k < degree_; ++k)
    for (int power = 0; power < degree_; ++power)
      powers(k, power) = std::pow(at(static_cast<std::size_t>(k)), power);
  const Eigen::MatrixXd back = solved(powers, Eigen::MatrixXd::Identity(degree_, degree_));
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, quantities, Eigen::RowMajor>;
  for (const auto& [edge, both] : sides) {
    if (both.size() != 2) continue;
    Rows sum = Rows::Zero(degree_, quantities);
    for (const Side& side : both)
      sum -= 0.5 * Eigen::Map<const Rows>(across.data() + side.of * terms * width, degree_, quantities);
    for (const Side& side : both) {
      edges_[side.of] = static_cast<std::int32_t>(turns_.size() / (terms * width));
      // the other way round, t becomes 1 - t
      const Rows terms_of = back * (side.forward ? sum : Rows(sum.colwise().reverse()));
      turns_.insert(turns_.end(), terms_of.data(), terms_of.data() + terms_of.size());
    }
  }
}

void FieldPatches::fill(const SurfacePlace& place, bool root, SiteModel& model) const {
  const SurfaceMap& map = field_->rest().map();
  const SurfaceMap::OnFacet where = map.on_facet(place);
  const SubFacet part = sub_facet_at(where.share, parts_);
  Shape shape = shape_at(part.share, degree_);
  const std::array<Vec3, 3> flat = map.flat_slopes(place.facet);
  const Vec3 heights(1 / flat[2].norm(), 1 / flat[0].norm(), 1 / flat[1].norm());
  add_ramps(part.share, heights / parts_, degree_, shape);
  std::array<const double*, Shape::size> rows{};
  std::array<double[4], Shape::size> weights{};  // of value, and of its slopes in space
  int count = 0;
  const double turn = part.sign * parts_;
  const auto add = [&](std::size_t k, const double* row) {
    const Vec3 slope = turn * (shape.slope[k][0] * where.by[0] + shape.slope[k][1] * where.by[1] +
                               shape.slope[k][2] * where.by[2]);
    double* weight = weights[static_cast<std::size_t>(count)];
    weight[0] = shape.value[k], weight[1] = slope[0], weight[2] = slope[1], weight[3] = slope[2];
    rows[static_cast<std::size_t>(count++)] = row;
  };
  const auto first = static_cast<std::size_t>(first_[static_cast<std::size_t>(place.facet)]);
  std::size_t k = 0;
  for (int i = 0; i <= degree_; ++i)
    for (int j = 0; i + j <= degree_; ++j)
      add(k++, row_of(values_, points_[first + number_of(part, i, j, degree_, parts_)]).data());
  const std::int32_t* edge =
      &edges_[static_cast<std::size_t>(first_edge_[static_cast<std::size_t>(place.facet)]) +
              3 * part_number(part, parts_)];
  for (int side = 0; side < 3; ++side)
    for (int power = 0; power < degree_ && edge[side] >= 0; ++power)
      add(static_cast<std::size_t>(most_places + side * most_patch_degree + power),
          row_of(turns_, edge[side] * degree_ + power).data());
  static_assert(quantities == place_terms);
  double sums[4][place_terms];
  site_kernels().places(rows.data(), weights.data(), count, sums);
  const Eigen::Map<const Quantities> value(sums[0]);
  const Eigen::Map<const Eigen::Matrix<double, quantities, 3>> slope(sums[1]);
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
  model.take(where, rest, value.tail<static_cast<int>(jet_size)>(),
             slope.bottomRows<static_cast<int>(jet_size)>(), root, field_->options().theta);
}

}  // namespace forefeel
