#include "approx/methods/older_methods.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/common/error.hpp"

namespace forefeel {

std::string_view name(Method method) {
  switch (method) {
    case Method::rbf:
      return "rbf";
    case Method::trilinear:
      return "trilinear";
    case Method::tricubic:
      return "tricubic";
    case Method::deflection:
      return "deflection";
    case Method::two_force:
      return "two-force";
    case Method::offline_rbf:
      return "offline-rbf";
    case Method::rbf_network:
      return "rbf-network";
  }
  return "";
}

std::span<const Method> all_methods() {
  static constexpr Method methods[] = {Method::rbf,        Method::trilinear, Method::tricubic,
                                       Method::deflection, Method::two_force, Method::offline_rbf,
                                       Method::rbf_network};
  return methods;
}

DeflectionCurves::DeflectionCurves(std::span<const State> states) {
  std::vector<const State*> sorted;
  for (const State& s : states)
    if (s.usable() && s.at.norm() > 0) sorted.push_back(&s);
  std::ranges::stable_sort(sorted, {}, [](const State* s) { return s->at.norm(); });
  for (const State* s : sorted) {
    const double depth = s->at.norm();
    const Vec3 direction = s->at / depth;
    auto curve = std::ranges::find_if(
        curves_, [&](const Curve& c) { return (c.direction - direction).norm() < 1e-6; });
    if (curve == curves_.end()) {
      curves_.push_back({direction, {0.0}, {Vec3::Zero()}});
      curve = curves_.end() - 1;
    }
    if (!(depth > curve->depth.back() * (1 + 1e-9))) continue;  // the curve already reaches there
    curve->depth.push_back(depth);
    curve->force.push_back(s->force);
  }
  // A direction with a single state would hide longer curves beside it; such directions are used only if
  // there are fewer than three longer curves.
  if (std::ranges::count_if(curves_, [](const Curve& c) { return c.depth.size() > 2; }) >= 3)
    std::erase_if(curves_, [](const Curve& c) { return c.depth.size() <= 2; });
}

Vec3 DeflectionCurves::Curve::at(double d) const {
  std::size_t i = 1;
  while (i + 1 < depth.size() && depth[i] < d) ++i;
  const double t = (d - depth[i - 1]) / (depth[i] - depth[i - 1]);
  return force[i - 1] + t * (force[i] - force[i - 1]);
}

Vec3 DeflectionCurves::force(const Vec3& x) const {
  const double depth = x.norm();
  if (curves_.empty() || !(depth > 0) || !std::isfinite(depth)) return Vec3::Zero();
  const Vec3 direction = x / depth;
  std::array<const Curve*, 3> best{};
  std::array<double, 3> along{-2, -2, -2};
  for (const Curve& c : curves_) {
    double cosine = c.direction.dot(direction);
    const Curve* curve = &c;
    for (std::size_t i = 0; i < 3; ++i)
      if (cosine > along[i]) {
        std::swap(cosine, along[i]);
        std::swap(curve, best[i]);
      }
  }
  // Weights with which the three directions add up to that of x: exact for a linear body. If the three lie in
  // a plane, the nearest direction alone.
  Vec3 weight = Vec3::UnitX();
  if (best[2] != nullptr) {
    Mat3 frame;
    for (int i = 0; i < 3; ++i) frame.col(i) = best[std::size_t(i)]->direction;
    const Vec3 solved = frame.partialPivLu().solve(direction);
    if (solved.allFinite() && solved.cwiseAbs().maxCoeff() < 3) weight = solved;
  }
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i)
    if (best[i] != nullptr && weight[Eigen::Index(i)] != 0)
      sum += weight[Eigen::Index(i)] * best[i]->at(depth);
  return sum;
}

TwoForce::TwoForce(std::span<const State> states) {
  for (const State& s : states)
    if (s.usable()) {
      points_.push_back(s.at);
      forces_.push_back(s.force);
    }
}

Vec3 TwoForce::force(const Vec3& x) const {
  if (points_.empty()) return Vec3::Zero();
  const std::size_t first = detail::nearest_of(points_, x);
  const Vec3 nearest = points_[first];
  std::size_t second = points_.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double squared = (points_[i] - x).squaredNorm();
    if ((second == points_.size() || squared < least) && (points_[i] - nearest).squaredNorm() > 0) {
      least = squared;
      second = i;
    }
  }
  if (second == points_.size()) return forces_[first];
  const Vec3 span = points_[first] - points_[second];
  return forces_[first] +
         (x - points_[first]).dot(span) / span.squaredNorm() * (forces_[first] - forces_[second]);
}

namespace {

// Positions of the network are centred and of size 1; positions nearer than this count as equal. It is far
// above the rounding error of states a kilometre from the origin and far below any distance that matters.
constexpr double tie = 1e-8;

// Rank of every point by x, y and z. Coordinates that differ by rounding have the same rank: a rank ends at a
// gap in the sorted order, so that no rounding grid can separate two equal coordinates.
std::vector<std::array<std::size_t, 3>> ranks_of(const std::vector<Vec3>& points) {
  std::vector<std::array<std::size_t, 3>> ranks(points.size());
  std::vector<std::size_t> order(points.size());
  for (std::size_t d = 0; d < 3; ++d) {
    const auto along = [&](std::size_t i) { return points[i][Eigen::Index(d)]; };
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, along);
    std::size_t rank = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (k > 0 && along(order[k]) - along(order[k - 1]) > tie) ++rank;
      ranks[order[k]][d] = rank;
    }
  }
  return ranks;
}

// Farthest-point sampling, from the point nearest to the origin on; the first of `points` among equals.
std::vector<Vec3> spread(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<Vec3> chosen;
  std::vector<double> distance(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) distance[i] = points[i].norm();
  const double least = *std::ranges::min_element(distance);
  auto next = std::ranges::find_if(distance, [&](double r) { return r <= least + tie; });
  std::vector<double> far(points.size(), 1e300);
  for (auto i = std::size_t(next - distance.begin()); chosen.size() < count && far[i] > tie;) {
    chosen.push_back(points[i]);
    for (std::size_t j = 0; j < points.size(); ++j)
      far[j] = std::min(far[j], (points[j] - chosen.back()).norm());
    const double most = *std::ranges::max_element(far);
    i = std::size_t(std::ranges::find_if(far, [&](double r) { return r >= most - tie; }) - far.begin());
  }
  return chosen;
}

}  // namespace

std::size_t RbfNetwork::centres_of(std::size_t states, std::size_t wished) {
  return std::min(states, wished > 0 ? wished : std::max<std::size_t>(10, states / 5));
}

RbfNetwork::RbfNetwork(std::span<const State> states, std::size_t centres) {
  std::vector<const State*> known;
  for (const State& s : states)
    if (s.usable()) known.push_back(&s);
  const std::size_t n = known.size();
  centres = centres_of(n, centres);
  // Relative to the first state, so that the distance to the origin of coordinates does not matter.
  const Vec3 origin = known[0]->at;
  Vec3 mean = Vec3::Zero();
  for (const State* s : known) mean += (s->at - origin) / double(n);
  middle_ = origin + mean;
  scale_ = 0;
  for (const State* s : known) scale_ = std::max(scale_, (s->at - middle_).norm());
  if (!(scale_ > 0)) scale_ = 1;
  std::vector<Vec3> points;
  for (const State* s : known) points.emplace_back((s->at - middle_) / scale_);
  // Sorted by position, so that neither the centres nor the sums depend on the order of the states.
  const auto ranks = ranks_of(points);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return ranks[i]; });
  std::vector<Vec3> sorted;
  for (const std::size_t i : order) sorted.push_back(points[i]);
  centres_ = spread(sorted, centres);
  const auto m = static_cast<Eigen::Index>(centres_.size());
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(n), m + 4);
  Eigen::MatrixXd right(static_cast<Eigen::Index>(n), 3);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3& y = sorted[i];
    for (Eigen::Index j = 0; j < m; ++j) {
      const double r = (y - centres_[std::size_t(j)]).norm();
      matrix(row, j) = r * r * r;
    }
    matrix(row, m) = 1;
    matrix.block<1, 3>(row, m + 1) = y.transpose();
    right.row(row) = known[order[i]]->force.transpose();
  }
  // If the states do not determine the weights (as many centres as states, states in a plane), the smallest weights are
  // used, because they do not depend on the order in which columns are eliminated.
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factor;
  factor.setThreshold(1e-10);
  factor.compute(matrix);
  weights_ = factor.solve(right);
}

Vec3 RbfNetwork::force(const Vec3& x) const {
  const auto m = static_cast<Eigen::Index>(centres_.size());
  const Vec3 y = (x - middle_) / scale_;
  Vec3 sum = (weights_.row(m) + y.transpose() * weights_.bottomRows<3>()).transpose();
  for (Eigen::Index j = 0; j < m; ++j) {
    const double r = (y - centres_[std::size_t(j)]).norm();
    sum += r * r * r * weights_.row(j).transpose();
  }
  return sum;
}

Approximation::Approximation(Method method, std::span<const State> states, const MethodOptions& options)
    : field_(TwoForce(std::span<const State>{})) {
  if (std::ranges::none_of(states, &State::usable))
    throw InputError("states", "none is solved, expected at least one");
  switch (method) {
    case Method::rbf:
      throw InputError("method", "rbf follows the HIP, expected one of the fixed methods");
    case Method::trilinear:
    case Method::tricubic: {
      LatticeField field(states, options.spacing, method == Method::tricubic);
      if (field.size() < 8)
        throw InputError("states",
                         "too few lie on the lattice of the spacing, expected at least a cell of 8");
      field_ = std::move(field);
      break;
    }
    case Method::deflection:
      field_ = DeflectionCurves(states);
      break;
    case Method::two_force:
      field_ = TwoForce(states);
      break;
    case Method::offline_rbf: {
      Vec3 middle = Vec3::Zero();
      for (const State& s : states) middle += s.at / double(states.size());
      field_ = fit_model(states, options.model, middle);
      break;
    }
    case Method::rbf_network:
      field_ = RbfNetwork(states, options.centres);
      break;
  }
  find_bound(states);
}

void Approximation::find_bound(std::span<const State> states) {
  std::vector<const State*> known;
  for (const State& s : states)
    if (s.usable()) {
      points_.insert(static_cast<std::uint32_t>(known.size()), s.at);
      known.push_back(&s);
    }
  std::vector<PointOctree::Neighbour> near;
  for (const State* s : known) {
    largest_ = std::max(largest_, s->force.norm());
    if (s->has_stiffness()) steepest_ = std::max(steepest_, s->stiffness.norm());
    points_.nearest(s->at, 4, near);
    const auto other = std::ranges::find_if(near, [](const auto& n) { return n.squared > 0; });
    if (other != near.end())
      steepest_ =
          std::max(steepest_, (s->force - known[other->id]->force).norm() / std::sqrt(other->squared));
  }
}

double Approximation::bound(const Vec3& x) const {
  if (const Model* model = std::get_if<Model>(&field_)) return model->force_bound();
  return largest_ + 2 * steepest_ * std::sqrt(points_.nearest(x).squared);
}

Vec3 Approximation::force(const Vec3& x) const {
  const Vec3 force = std::visit([&](const auto& field) { return Vec3(field.force(x)); }, field_);
  const double norm = force.norm();
  if (norm <= largest_) return force;
  const double most = bound(x);
  return norm <= most ? force : Vec3(force * (most / norm * (1 - 1e-15)));
}

}  // namespace forefeel
