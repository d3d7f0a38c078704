#include "approx/judge/left_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "approx/judge/position_groups.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t most_whole = 1500;  // states: above, patches are tried
constexpr std::size_t patches = 5, patch_states = 700;
constexpr std::size_t parts = 8;
constexpr std::size_t most_wanted = 400;  // places that are matched
constexpr std::size_t beside = 12;        // held positions on either side in rank

// One way to leave out: the part of each position.
struct Division {
  PositionGroups groups;
  std::vector<std::uint32_t> part;  // of each group
  std::size_t count = 0;            // of parts
};

Division divide(std::span<const Vec3> at, PositionGroups groups) {
  Division division{.groups = std::move(groups), .part = {}};
  if (division.groups.count < 3) return division;
  division.count = std::min(parts, division.groups.count);
  division.part = spread_over_parts(at, division.groups, division.count);
  return division;
}

// From each position to the nearest one of another part [m].
std::vector<double> distances(std::span<const Vec3> at, const Division& division) {
  std::vector<double> away(at.size(), infinite);
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < at.size(); ++j)
      if (division.part[division.groups.of[i]] != division.part[division.groups.of[j]])
        away[i] = std::min(away[i], (at[j] - at[i]).squaredNorm());
  for (double& a : away) a = std::sqrt(a);
  return away;
}

Division best_division(std::span<const Vec3> at, std::span<const double> wanted) {
  PositionGroups usual = position_groups(at);
  if (wanted.empty()) return divide(at, std::move(usual));
  std::vector<PositionGroups> ways;
  if (usual.natural) ways.push_back(std::move(usual));
  for (const std::size_t size : {8u, 4u, 2u, 1u}) ways.push_back(compact_groups(at, size));
  const double target = median({wanted.begin(), wanted.end()});
  Division best;
  double least = infinite;
  for (PositionGroups& way : ways) {  // from large to small groups: in a tie the larger is taken
    Division division = divide(at, std::move(way));
    if (division.count == 0) continue;
    const double found = median(distances(at, division));
    const double off = target > 0 && found > 0 ? std::abs(std::log(found / target)) : found;
    if (off < least) least = off, best = std::move(division);
  }
  return best;
}

void add_trials(std::span<const State> states, double inner, std::span<const double> wanted, double spacing,
                Trials& trials) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  const Division division = best_division(at, wanted);
  if (division.count == 0) return;
  const std::vector<double> away = distances(at, division);
  const PositionGroups& groups = division.groups;
  std::vector<char> used(groups.count, 1);
  if (inner < 1)  // the border of a patch is not one of the states: groups there stay known
    for (std::size_t i = 0; i < at.size(); ++i)
      if (i > static_cast<std::size_t>(inner * static_cast<double>(at.size()))) used[groups.of[i]] = 0;
  trials.groups += static_cast<std::size_t>(std::ranges::count(used, 1));
  for (std::uint32_t p = 0; p < (inner < 1 ? 1 : division.count); ++p) {
    Trial trial{
        .known = std::make_unique<StateSpace>(StateSpaceOptions{.spacing = spacing}), .held = {}, .away = {}};
    for (std::size_t i = 0; i < states.size(); ++i) {
      State light = states[i];
      light.displacements.reset();
      if (division.part[groups.of[i]] == p && used[groups.of[i]]) {
        trial.held.push_back(std::move(light));
        trial.away.push_back(away[i]);
      } else {
        trial.known->insert(std::move(light));
      }
    }
    trials.positions += trial.held.size();
    if (!trial.held.empty() && !trial.known->empty()) trials.each.push_back(std::move(trial));
  }
}

// Patches about states that lie far from each other, each ordered by distance from its middle.
void add_patches(std::span<const State> states, std::span<const double> wanted, double spacing,
                 Trials& trials) {
  std::vector<double> away(states.size(), infinite);
  std::size_t middle = 0;
  for (std::size_t patch = 0; patch < patches; ++patch) {
    std::vector<std::size_t> order(states.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto distance = [&](std::size_t i) { return (states[i].at - states[middle].at).squaredNorm(); };
    std::ranges::nth_element(order, order.begin() + patch_states, {}, distance);
    order.resize(patch_states);
    std::ranges::stable_sort(order, {}, distance);
    std::vector<State> near;
    for (const std::size_t i : order) near.push_back(states[i]);
    add_trials(near, 0.5, wanted, spacing, trials);
    for (std::size_t i = 0; i < states.size(); ++i) away[i] = std::min(away[i], distance(i));
    middle = static_cast<std::size_t>(std::ranges::max_element(away) - away.begin());
  }
}

}  // namespace

Trials leave_out(std::span<const State> states, std::span<const double> wanted, double spacing) {
  Trials trials;
  if (states.size() <= most_whole)
    add_trials(states, 1, wanted, spacing, trials);
  else
    add_patches(states, wanted, spacing, trials);
  return trials;
}

std::vector<double> expected_quantiles(std::span<const double> errors, std::span<const double> away,
                                       std::span<const double> wanted, std::span<const double> shares) {
  std::vector<double> pooled;
  if (wanted.empty() || errors.size() <= 2 * beside) {
    pooled.assign(errors.begin(), errors.end());
  } else {
    std::vector<std::pair<double, double>> by_distance;
    for (std::size_t i = 0; i < errors.size(); ++i) by_distance.emplace_back(away[i], errors[i]);
    std::ranges::sort(by_distance);
    const std::size_t stride = std::max<std::size_t>(1, wanted.size() / most_wanted);
    for (std::size_t i = 0; i < wanted.size(); i += stride) {
      const auto at = std::ranges::lower_bound(by_distance, wanted[i], {}, &std::pair<double, double>::first);
      const auto rank = static_cast<std::size_t>(at - by_distance.begin());
      const std::size_t first =
          std::min(rank > beside ? rank - beside : 0, by_distance.size() - (2 * beside + 1));
      for (std::size_t k = 0; k <= 2 * beside; ++k) pooled.push_back(by_distance[first + k].second);
    }
  }
  std::vector<double> quantiles;
  for (const double share : shares) quantiles.push_back(quantile_of(pooled, share));
  return quantiles;
}

}  // namespace forefeel
