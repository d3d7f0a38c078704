#include "approx/methods/older_methods.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "approx/methods/rbf_network.hpp"
#include "approx/model/lattice_field.hpp"
#include "approx/model/updater.hpp"
#include "geometry/common/enum_names.hpp"
#include "geometry/common/error.hpp"
#include "geometry/index/point_octree.hpp"

namespace forefeel {

std::string_view name(Method method) {
  return name_in<Method::rbf_network>(
      {"rbf", "trilinear", "tricubic", "deflection", "two-force", "offline-rbf", "rbf-network"}, method);
}

std::span<const Method> all_methods() {
  static constexpr Method methods[] = {Method::rbf,        Method::trilinear, Method::tricubic,
                                       Method::deflection, Method::two_force, Method::offline_rbf,
                                       Method::rbf_network};
  return methods;
}

namespace {

class DeflectionCurves {
 public:
  explicit DeflectionCurves(std::span<const State> states);
  Vec3 force(const Vec3& x) const;

 private:
  struct Curve {
    Vec3 direction;
    std::vector<double> depth;  // ascending, from 0 [m]
    std::vector<Vec3> force;
    Vec3 at(double d) const;  // linear; extrapolated from the last two states
  };
  std::vector<Curve> curves_;
};

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

class TwoForce {
 public:
  explicit TwoForce(std::span<const State> states);
  Vec3 force(const Vec3& x) const;

 private:
  std::vector<Vec3> points_, forces_;
};

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

}  // namespace

struct Approximation::Impl {
  std::variant<LatticeField, DeflectionCurves, TwoForce, RbfNetwork, Model> field =
      TwoForce(std::span<const State>{});
  PointOctree points;
  double largest = 0, steepest = 0;

  void find_bound(std::span<const State> states);
  double bound(const Vec3& x) const;
};

Approximation::Approximation(Method method, std::span<const State> states, const MethodOptions& options) {
  if (std::ranges::none_of(states, &State::usable))
    throw InputError("states", "none is solved, expected at least one");
  auto impl = std::make_shared<Impl>();
  switch (method) {
    case Method::rbf:
      throw InputError("method", "rbf follows the HIP, expected one of the fixed methods");
    case Method::trilinear:
    case Method::tricubic: {
      LatticeField field(states, options.spacing, method == Method::tricubic);
      if (field.size() < 8)
        throw InputError("states",
                         "too few lie on the lattice of the spacing, expected at least a cell of 8");
      impl->field = std::move(field);
      break;
    }
    case Method::deflection:
      impl->field = DeflectionCurves(states);
      break;
    case Method::two_force:
      impl->field = TwoForce(states);
      break;
    case Method::offline_rbf: {
      Vec3 middle = Vec3::Zero();
      for (const State& s : states) middle += s.at / double(states.size());
      impl->field = fit_model(states, options.model, middle);
      break;
    }
    case Method::rbf_network:
      impl->field = RbfNetwork(states, options.centres);
      break;
  }
  impl->find_bound(states);
  impl_ = std::move(impl);
}

void Approximation::Impl::find_bound(std::span<const State> states) {
  std::vector<const State*> known;
  for (const State& s : states)
    if (s.usable()) {
      points.insert(static_cast<std::uint32_t>(known.size()), s.at);
      known.push_back(&s);
    }
  std::vector<PointOctree::Neighbour> near;
  for (const State* s : known) {
    largest = std::max(largest, s->force.norm());
    if (s->has_stiffness()) steepest = std::max(steepest, s->stiffness.norm());
    points.nearest(s->at, 4, near);
    const auto other = std::ranges::find_if(near, [](const auto& n) { return n.squared > 0; });
    if (other != near.end())
      steepest = std::max(steepest, (s->force - known[other->id]->force).norm() / std::sqrt(other->squared));
  }
}

double Approximation::Impl::bound(const Vec3& x) const {
  if (const Model* model = std::get_if<Model>(&field)) return model->force_bound();
  return largest + 2 * steepest * std::sqrt(points.nearest(x).squared);
}

Answer Approximation::at(const Place& place) const noexcept {
  return {.force = force(place), .reach = {.bound = impl_->bound(place.x)}};
}

Vec3 Approximation::force(const Vec3& x) const noexcept {
  const Vec3 force = std::visit([&](const auto& field) { return Vec3(field.force(x)); }, impl_->field);
  const double norm = force.norm();
  if (norm <= impl_->largest) return force;
  const double most = impl_->bound(x);
  return norm <= most ? force : Vec3(force * (most / norm * (1 - 1e-15)));
}

}  // namespace forefeel
