#include "solver/jet/jet_maker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/common/dense.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

namespace {

using Matrix = Eigen::MatrixXd;

std::array<double, 3 * limit_direction_count> make_directions() {
  std::array<double, 3 * limit_direction_count> list{};
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

}  // namespace

const std::array<double, 3 * limit_direction_count>& limit_directions() {
  static const auto list = make_directions();
  return list;
}

const std::array<double, limit_direction_count>& limit_lengths() {
  static const auto list = [] {
    std::array<double, limit_direction_count> lengths{};
    for (std::size_t k = 0; k < limit_direction_count; ++k)
      lengths[k] = Eigen::Map<const Vec3>(limit_directions().data() + 3 * k).norm();
    return lengths;
  }();
  return list;
}

namespace {

using Power = std::array<int, 3>;
constexpr std::size_t pair_count = 6;
constexpr std::array<Power, pair_count> pairs{
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}};

double& coefficient(EnergyJet& jet, const Power& a, const Power& b) {
  return jet.coefficients[jet_index(a[0] + b[0], a[1] + b[1], a[2] + b[2])];
}

}  // namespace

JetMaker::JetMaker(std::shared_ptr<const Discretisation> discretisation) : d_(std::move(discretisation)) {
  second_.resize(static_cast<std::size_t>(d_->local_size()) * lane_count);
  hardness_.resize(d_->elements.count());
}

void JetMaker::curvature(const std::vector<double>& u, const std::vector<double>& tangent,
                         const JetDirections& directions) {
  std::ranges::fill(second_, 0.0);
  d_->elements.curvature(d_->local_size(), u.data(), tangent.data(), second_.data(), directions);
}

// E_3 = 1/3 q . u_1
void JetMaker::set_third(const std::vector<double>& tangent, EnergyJet& jet) const {
  constexpr std::array<Power, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const std::int64_t size = d_->local_size(), rows = size - 3;  // without the clamp
  std::array<std::array<double, lane_count>, 3> sums{};
  front_kernels().cross_lanes(rows, tangent.data(), 1, size, second_.data(), sums[0].data());
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t p = 0; p < pair_count; ++p) coefficient(jet, pairs[p], axes[c]) += sums[c][p] / 3;
}

// E_4 += factor a . b, of two forms of degree 2.
void JetMaker::add_product(const std::vector<double>& a, const std::vector<double>& b, double factor,
                           EnergyJet& jet) const {
  std::array<std::array<double, lane_count>, pair_count> gram{};
  for (std::size_t p = 0; p < pair_count; p += 3)
    front_kernels().cross_lanes(3 * d_->free_nodes, a.data() + p, lane_count, 1, b.data(), gram[p].data());
  for (std::size_t p = 0; p < pair_count; ++p)
    for (std::size_t r = 0; r < pair_count; ++r) coefficient(jet, pairs[p], pairs[r]) += factor * gram[p][r];
}

EnergyJet JetMaker::at(const std::vector<double>& u, const std::vector<double>& tangent,
                       const Factorisation& factor, int order) {
  const JetSolves solves{[&](double* b) { factor.solve_lanes(b); },
                         [&](double* b) { factor.half_solve_lanes(b); }};
  EnergyJet jet = at(u, tangent, solves, order);
  if (d_->elements.fine.jet)
    d_->elements.fine.jet->add_to(jet, Eigen::Map<const Vec3>(u.data() + 3 * d_->free_nodes));
  return jet;
}

EnergyJet JetMaker::at(const std::vector<double>& u, const std::vector<double>& tangent,
                       const JetSolves& solves, int order) {
  EnergyJet jet{.order = order};
  JetDirections directions{.count = static_cast<int>(limit_direction_count),
                           .ways = limit_directions().data(),
                           .lengths = limit_lengths().data(),
                           .hardness = hardness_.data()};
  if (order == 2) directions.reached = &jet.limit;  // else found along the path with V
  curvature(u, tangent, directions);
  set_third(tangent, jet);
  if (order < 3) return jet;
  const double* v = nullptr;
  if (order == 3) {
    solves.half(second_.data());
    add_product(second_, second_, -0.5, jet);
  } else {
    right_ = second_;
    for (double& value : second_) value = -value;
    solves.whole(second_.data());
    std::fill(second_.begin() + static_cast<std::ptrdiff_t>(3 * d_->free_nodes * lane_count), second_.end(),
              0.0);
    v = second_.data();
    add_product(right_, second_, 0.5, jet);
  }
  directions.reached = &jet.limit;
  d_->elements.path(d_->local_size(), u.data(), tangent.data(), v, jet.coefficients.data() + 10, directions);
  return jet;
}

}  // namespace forefeel
