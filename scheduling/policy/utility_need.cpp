#include "scheduling/policy/utility_need.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/common/halton.hpp"
#include "scheduling/motion/random.hpp"
#include "scheduling/policy/candidate_rows.hpp"
#include "scheduling/policy/need_policy.hpp"
#include "scheduling/policy/policies.hpp"

namespace forefeel {
namespace {

constexpr double none_known = 5;  // distance of a state where none is known [spacings]

// Points of the standard normal distribution: Halton's, mapped by Box and Muller, in opposite pairs.
std::vector<Vec3> normal_points() {
  constexpr std::size_t pairs = 8;
  std::vector<Vec3> points;
  for (std::size_t i = 1; i <= pairs; ++i) {
    const auto radius = [&](std::size_t base) { return std::sqrt(-2 * std::log(radical_inverse(i, base))); };
    const double angle = random::two_pi * radical_inverse(i, 3),
                 other = random::two_pi * radical_inverse(i, 7);
    const Vec3 point(radius(2) * std::cos(angle), radius(2) * std::sin(angle), radius(5) * std::cos(other));
    points.push_back(point);
    points.push_back(-point);
  }
  return points;
}

}  // namespace

double UtilityNeed::loss(double delta) const {
  const double place = delta / (none_known * spacing_) * static_cast<double>(losses_.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), losses_.size() - 2);
  const double w = place - static_cast<double>(below);
  return (1 - w) * losses_[below] + w * losses_[below + 1];
}

void UtilityNeed::tabulate() {
  for (std::size_t k = 0; k < losses_.size(); ++k) {
    const double error =
        fit_.median(none_known * static_cast<double>(k) / static_cast<double>(losses_.size() - 1), 0);
    losses_[k] = error / (1 + error);
  }
}

void UtilityNeed::learn(const PlannerView& view) {
  for (; known_ < space_->size(); ++known_) {
    if (known_ >= view.surprises.size() || !std::isfinite(view.surprises[known_])) continue;
    const Vec3 at = (*space_)[StateId{static_cast<std::uint32_t>(known_)}].at;
    space_->nearest(at, 1 + (space_->size() - known_), near_);
    double delta = none_known * spacing_;
    for (const StateId id : near_)
      if (id.value < known_) delta = std::min(delta, ((*space_)[id].at - at).norm());
    fit_.learn(delta / spacing_, 0, std::clamp(std::log(double(view.surprises[known_]) + 1e-9), -8.0, 8.0));
  }
}

void UtilityNeed::look(const PlannerView& view) {
  if (space_ != &view.space || known_ > view.space.size()) {
    space_ = &view.space;
    known_ = 0;
    fit_ = ErrorFit();
  }
  spacing_ = view.space.options().spacing;
  solve_ = std::max(view.solve_seconds, 1e-3);
  learn(view);
  tabulate();
  places_.clear();
  static const std::vector<Vec3> normal = normal_points();
  const auto path = view.predicted;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const auto middle = [&](std::size_t i) { return 0.5 * (path[i].horizon + path[i - 1].horizon); };
    const double from = k > 0 ? middle(k) : path[k].horizon,
                 until = k + 1 < path.size() ? middle(k + 1) : path[k].horizon;
    const double time = until - std::max(from, solve_);
    if (!(time > 1e-9)) continue;  // [s]: rounding
    const std::size_t count = path[k].deviation > 0 ? normal.size() : 1;
    for (std::size_t j = 0; j < count; ++j) {
      const Vec3 at = count > 1 ? Vec3(path[k].at + path[k].deviation * normal[j]) : path[k].at;
      Place place{.at = folded(at, view.space.options().box),
                  .weight = time / static_cast<double>(count),
                  .delta = none_known * spacing_};
      space_->nearest(place.at, 1, near_);
      if (!near_.empty()) place.delta = std::min(place.delta, ((*space_)[near_[0]].at - place.at).norm());
      places_.push_back(place);
    }
  }
  pend(view.pending);
}

void UtilityNeed::pend(std::span<const Vec3> pending) {
  left_ = places_;
  for (Place& place : left_)
    for (const Vec3& p : pending) place.delta = std::min(place.delta, (p - place.at).norm());
}

void UtilityNeed::worth(std::span<const Candidate> candidates, std::span<double> out) const {
  std::ranges::fill(out, 0.0);
  if (candidates.empty()) return;
  double all = 0;
  for (const Place& place : left_) all += place.weight;
  const CandidateRows rows(candidates, 2 * spacing_);
  const double *x = rows.xyz(), *y = x + candidates.size(), *z = y + candidates.size();
  for (const Place& place : left_) {
    const double now = loss(place.delta), squared = place.delta * place.delta;
    rows.near(place.at, place.delta, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const double d2 = (Vec3(x[i], y[i], z[i]) - place.at).squaredNorm();
        if (d2 < squared) out[rows.candidate(i)] += place.weight * (now - loss(std::sqrt(d2)));
      }
    });
  }
  for (double& worth : out) worth /= all > 0 ? all * solve_ : 1;
}

std::unique_ptr<Policy> make_utility(FactoryContext&) {
  return std::make_unique<NeedPolicy<UtilityNeed>>("utility", NeedPath::predicted, UtilityNeed());
}

}  // namespace forefeel
