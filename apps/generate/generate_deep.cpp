#include "apps/generate/generate_deep.hpp"

#include <algorithm>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr std::size_t fresh_places = 100;   // of a round;
constexpr std::size_t checked_again = 400;  // these and more, where they are within the error: they decide
constexpr std::size_t looked_at = 1000;     // places of a round among which the worst are found
constexpr std::size_t states_a_round = 50;  // beside the fresh ones
constexpr double sites_a_round = 0.25;      // of the field's
constexpr int most_rounds = 200, patience = 10;  // rounds over which p95 must have become better
constexpr unsigned first_seed = 7, others = 1000;

std::vector<SurfacePlace> sites_of(std::span<const SitedPlace> places) {
  std::vector<SurfacePlace> sites;
  for (const SitedPlace& place : places) sites.push_back(place.site);
  return sites;
}

std::vector<State> counting(const std::vector<SitedPlace>& places, const std::vector<State>& states) {
  std::vector<State> kept;
  for (std::size_t i = 0; i < states.size(); ++i)
    if (places[i].counts()) kept.push_back(states[i]);
  return kept;
}

// The p95 of a hundred places scatters by a third, so the median of several rounds is compared with that of those
// before.
bool helps_no_longer(const std::vector<double>& p95) {
  constexpr double less = 0.95;
  if (static_cast<int>(p95.size()) < 2 * patience) return false;
  const auto end = p95.end(), middle = end - patience, start = middle - patience;
  return median({middle, end}) > less * median({start, middle});
}

}  // namespace

DeepRounds refine_to(const DeepWork& work) {
  DeepRounds result{.known = std::make_shared<const DeepStates>(work.field), .error = {}};
  std::vector<double> p95;  // at the first fresh places of each round
  for (int round = 0;; ++round) {
    const auto seed = static_cast<unsigned>(round);
    std::vector<SitedPlace> fresh;
    std::vector<State> solved, measured;
    for (const std::size_t count : {fresh_places, checked_again}) {
      fresh = work.places(count, first_seed + seed);  // those before, and more
      solved = work.solve(fresh);
      if (work.stop.stop_requested()) return result;
      measured = counting(fresh, solved);
      result.error = field_errors(*result.known, measured, work.floor);
      work.tell(round, result.error.p95);
      if (count == fresh_places) p95.push_back(result.error.p95);
      if (!(result.error.p95 <= work.error)) break;
    }
    if (result.error.states == 0 || round == most_rounds) return result;
    if (fresh.size() > fresh_places && result.error.surely_within(work.error)) return result;
    if (helps_no_longer(p95)) return result;

    ++result.rounds;
    std::vector<SitedPlace> candidates = work.places(looked_at, others + seed);
    std::erase_if(candidates, [](const SitedPlace& place) { return !place.counts(); });
    if (share_between(*work.field, measured, work.error, work.floor) > 0.5) {
      const auto count =
          static_cast<std::size_t>(sites_a_round * static_cast<double>(work.field->size())) + 1;
      const auto more =
          worst_places(*result.known, candidates, count, work.floor, WorstBy::neighbours, work.threads);
      result.known = result.known->with(work.jets(sites_of(more)));
    }
    const auto worst =
        worst_places(*result.known, candidates, states_a_round, work.floor, WorstBy::estimate, work.threads);
    for (const auto& [places, states] : {std::pair(fresh, solved), std::pair(worst, work.solve(worst))}) {
      result.known = result.known->with(work.jets(sites_of(places)));
      result.known = result.known->with(states);
    }
    if (work.stop.stop_requested()) return result;
  }
}

}  // namespace forefeel
