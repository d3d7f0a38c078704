#include "scheduling/placement/candidate_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace forefeel {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;        // estimates below it are ordered by distance
constexpr std::size_t most_judged = 16;  // for one answer
constexpr std::size_t first_judged = 4;  // before c is believed

}  // namespace

CandidateErrors::CandidateErrors(std::vector<Vec3> candidates, const StateSpaceOptions& space,
                                 const EstimateOptions& options)
    : candidates_(std::move(candidates)),
      space_(space),
      options_(options),
      estimator_(space_, options_),
      known_(candidates_.size(), Known{.distance = endless}) {}

void CandidateErrors::tell(const State& state) {
  if (!space_.insert(state).is_new) return;
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const double distance = (candidates_[i] - state.at).norm();
    known_[i].distance = std::min(known_[i].distance, distance);
    if (distance < known_[i].reach) known_[i].now = false;
  }
}

void CandidateErrors::judge(std::size_t i) {
  Known& known = known_[i];
  known.estimate = estimator_(candidates_[i]);
  known.judged = known.now = true;
  ++judged_;
  // The states of the model are those nearest to x, those of the interpolants the ones around the nearest of them.
  const std::size_t most = std::max(options_.interpolated, options_.model.neighbours);
  std::vector<StateId> near;
  space_.nearest(candidates_[i], 1, near);
  known.reach = endless;
  if (space_.size() > most) {
    const Vec3 middle = space_[near[0]].at;
    space_.nearest(middle, most, near);
    known.reach = known.distance + (space_[near.back()].at - middle).norm();
  }
  const double d2 = known.distance * known.distance;
  known.growth = d2 > 0 ? known.estimate / d2 : 0;
  if (std::isfinite(known.growth)) growth_ = std::max(growth_, known.growth);
}

double CandidateErrors::expected(const Known& known) const {
  if (known.now) return known.estimate;
  if (!known.judged && judged_ < first_judged) return endless;
  const double growth = known.judged ? known.growth : growth_;
  return std::isfinite(known.distance) ? growth * known.distance * known.distance : endless;
}

std::optional<CandidateErrors::Worst> CandidateErrors::worst(std::span<const double> weights) {
  using Order = std::pair<double, double>;  // the larger first: weighted estimate, then distance
  const auto order = [&](std::size_t i) {
    const double value = std::min(expected(known_[i]), 1e9);
    return Order(value < rounding ? 0 : weights[i] * value, weights[i] * std::min(known_[i].distance, 1e9));
  };
  // The first in that order, of all or of those that are judged.
  const auto first = [&](bool judged) {
    std::optional<std::size_t> best;
    Order most{};
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (!(weights[i] > 0) || (judged && !known_[i].now)) continue;
      if (const Order mine = order(i); !best || mine > most) {
        best = i;
        most = mine;
      }
    }
    return best;
  };
  // While all states are around every place, they share one model and one pair of interpolants.
  const std::size_t n = space_.size();
  const std::size_t most = n <= options_.model.neighbours ? candidates_.size()
                           : n <= options_.interpolated   ? 4 * most_judged
                                                          : most_judged;
  for (std::size_t tried = 0;; ++tried) {
    const std::optional<std::size_t> best = first(tried >= most);
    if (!best) return {};
    if (known_[*best].now) return Worst{.index = *best, .estimate = known_[*best].estimate};
    judge(*best);
  }
}

}  // namespace forefeel
