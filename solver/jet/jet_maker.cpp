#include "solver/jet/jet_maker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/common/dense.hpp"
#include "solver/body/fine_jet.hpp"

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

namespace {

constexpr std::size_t pair_count = 6;
constexpr std::array<std::array<int, 2>, pair_count> pairs{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

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

void JetMaker::set_third(const std::vector<double>& tangent, EnergyJet& jet) const {
  const std::size_t size = static_cast<std::size_t>(d_->local_size()), rows = size - 3;  // without the clamp
  std::array<std::array<double, lane_count>, 3> sums{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double* u = tangent.data() + c * size;
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t p = 0; p < lane_count; ++p) sums[c][p] += second_[i * lane_count + p] * u[i];
  }
  for (std::size_t p = 0; p < pair_count; ++p)
    for (int c = 0; c < 3; ++c) {
      std::array<int, 3> power{};
      for (const int axis : {pairs[p][0], pairs[p][1], c}) ++power[static_cast<std::size_t>(axis)];
      jet.coefficients[jet_index(power[0], power[1], power[2])] += sums[static_cast<std::size_t>(c)][p] / 3;
    }
}

// fourth[k] += factor |sum_p a_p d_i d_j|^2 in the product of a with b.
void JetMaker::add_gram(const double* a, const double* b, double factor, double* fourth) const {
  const auto rows = static_cast<std::size_t>(3 * d_->free_nodes);
  std::array<std::array<double, lane_count>, pair_count> gram{};
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t p = 0; p < pair_count; ++p)
      for (std::size_t l = 0; l < lane_count; ++l)
        gram[p][l] += *(a + i * lane_count + p) * *(b + i * lane_count + l);
  for (std::size_t k = 0; k < path_direction_count; ++k) {
    const std::array<double, pair_count> m = pair_products(path_directions().data() + 3 * k);
    double square = 0;
    for (std::size_t p = 0; p < pair_count; ++p)
      for (std::size_t r = 0; r < pair_count; ++r) square += m[p] * gram[p][r] * m[r];
    *(fourth + k) += factor * square;
  }
}

EnergyJet JetMaker::at(const std::vector<double>& u, const std::vector<double>& tangent,
                       const Factorisation& factor, int order) {
  const JetSolves solves{[&](double* b) { factor.solve_lanes(b); },
                         [&](double* b) { factor.half_solve_lanes(b); }, d_->elements.pad};
  EnergyJet jet = at(u, tangent, solves, order);
  if (d_->elements.fine.jet)
    d_->elements.fine.jet->add_to(jet, Eigen::Map<const Vec3>(u.data() + 3 * d_->free_nodes));
  return jet;
}

EnergyJet JetMaker::at(const std::vector<double>& u, const std::vector<double>& tangent,
                       const JetSolves& solves, int order) {
  EnergyJet jet{.order = order};
  JetDirections directions{.count = static_cast<int>(path_direction_count),
                           .ways = path_directions().data(),
                           .lengths = path_lengths().data(),
                           .hardness = hardness_.data()};
  if (order == 2) directions.reached = &jet.limit;  // else found along the path with V
  curvature(u, tangent, directions);
  set_third(tangent, jet);
  const auto rows = static_cast<std::size_t>(3 * d_->free_nodes);
  std::array<double, path_direction_count> fourth{}, fifth{};
  const double* v = nullptr;
  if (order == 3) {
    solves.half(second_.data());
    add_gram(second_.data(), second_.data(), -0.5, fourth.data());
  } else if (order >= 4) {
    solves.whole(second_.data());
    std::fill(second_.begin() + static_cast<std::ptrdiff_t>(rows * lane_count), second_.end(), 0.0);
    for (double& value : second_) value = -value;
    v = second_.data();
    if (!solves.pad.pairs.empty()) {
      springs_.assign(second_.size(), 0.0);
      solves.pad.apply_lanes(v, springs_.data());
      add_gram(v, springs_.data(), 0.5, fourth.data());
    }
  }
  if (order >= 3) {
    std::array<double, 2 * path_direction_count> ends{};
    directions.reached = &jet.limit;
    d_->elements.path(d_->local_size(), u.data(), tangent.data(), v, ends.data(), directions);
    for (std::size_t k = 0; k < path_direction_count; ++k) {
      fourth[k] += ends[2 * k];
      fifth[k] = ends[2 * k + 1];
    }
    set_fourth(fourth, jet);
    if (order >= 4) set_fifth(fifth, jet);
  }
  return jet;
}

}  // namespace forefeel
