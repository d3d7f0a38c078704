#include "scheduling/placement/placement_estimate.hpp"

#include <algorithm>
#include <limits>

namespace forefeel {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr std::size_t kept_fits = 512;

// Axes along which a box is so thin that states do not differ in it.
std::array<bool, 3> flat_axes(const Box& box) {
  const Vec3 size = box.size();
  std::array<bool, 3> flat{};
  for (unsigned a = 0; a < 3; ++a) flat[a] = size[a] <= 1e-6 * size.maxCoeff();
  return flat;
}

}  // namespace

ErrorEstimator::ErrorEstimator(const StateSpace& space, EstimateOptions options)
    : space_(space),
      options_(options),
      flat_(flat_axes(space.options().box)),
      updater_(space, options.model) {
  model_.reserve(options_.model);
}

Vec3 ErrorEstimator::force(const Vec3& x) {
  // If the neighbour set depends on x, each x gets its own model; else there is one model for each size of the space.
  if (space_.size() > options_.model.neighbours || space_.size() != seen_) updater_.forget();
  seen_ = space_.size();
  updater_.update(x, model_);
  return model_.force(x);
}

// All states or, if there are many, those around the state nearest to x, so that many x share an interpolant.
const ErrorEstimator::Pair& ErrorEstimator::interpolants(const Vec3& x) {
  const std::size_t most = options_.interpolated;
  space_.nearest(x, space_.size() <= most ? most : 1, ids_);
  if (space_.size() > most) space_.nearest(Vec3(space_[ids_[0]].at), most, ids_);
  std::ranges::sort(ids_);
  const auto known = fits_.find(ids_);
  if (known != fits_.end()) return known->second;
  if (fits_.size() >= kept_fits) fits_.clear();
  std::vector<const State*> states;
  for (const StateId id : ids_) states.push_back(&space_[id]);
  Pair pair{.fine = EnergyInterpolant::fit(states, 4, flat_),
            .coarse = EnergyInterpolant::fit(states, 3, flat_)};
  return fits_.emplace(ids_, std::move(pair)).first->second;
}

double ErrorEstimator::operator()(const Vec3& x) {
  if (space_.empty()) return never;
  const Vec3 model = force(x);
  if (model_.has_jets()) return model_.at({x}).error / std::max(model.norm(), options_.floor);
  const Pair& pair = interpolants(x);
  if (!pair.fine || !pair.coarse) return never;
  const Vec3 fine = pair.fine->force(x), coarse = pair.coarse->force(x);
  const double error = (model - fine).norm() + 0.5 * (fine - coarse).norm();
  const double estimate = 1.1 * error / std::max(model.norm(), options_.floor);
  return estimate == estimate ? estimate : never;
}

}  // namespace forefeel
