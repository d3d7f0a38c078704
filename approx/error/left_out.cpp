#include "approx/error/left_out.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "approx/measured/position_groups.hpp"
#include "geometry/common/cube_directions.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t most_whole = 1500;  // states: above, boxes of them are divided, or patches are tried
constexpr std::size_t most_boxes = 1200;
constexpr std::size_t most_natural = 20'000;  // states that natural groups are sought of
constexpr std::size_t patches = 5, patch_states = 700;
constexpr std::size_t most_wanted = 400;  // places that are matched
constexpr std::size_t beside = 12;        // held positions on either side in rank
constexpr std::size_t least_known = 8;    // states that stay known beside a cap
constexpr std::ptrdiff_t enough_outside =
    20;  // positions in caps, for bars of 95 %; deeper caps are tried for fewer
constexpr int most_deeper = 4;
constexpr double least_direction = 0.02;  // share of the places outside that makes a direction count

void see_held(Trial& trial) {
  if (trial.held.empty() || trial.known->empty()) return;
  const PlaceLocator locate(*trial.known);
  for (const State& held : trial.held) trial.seen.push_back(locate(held.at));
}

void add_trial(Trial trial, Trials& trials) {
  if (trial.held.empty() || trial.known->empty()) return;
  if (trial.seen.empty()) see_held(trial);
  trials.positions += trial.held.size();
  trials.each.push_back(std::move(trial));
}

State without_displacements(const State& state) {
  State light = state;
  light.displacements.reset();
  return light;
}

// Holds out each part of a division in turn. group, held: of each state; a state that is not held with its part is
// left out of both.
void add_division(std::span<const State> states, const Division& division,
                  std::span<const std::uint32_t> group, std::span<const char> held, double spacing,
                  Trials& trials) {
  std::vector<Trial> parts(division.count);
#pragma omp parallel for schedule(dynamic, 1)
  for (std::uint32_t p = 0; p < division.count; ++p) {
    Trial& trial = parts[p];
    trial.known = std::make_unique<StateSpace>(StateSpaceOptions{.spacing = spacing});
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (division.part[group[i]] != p)
        trial.known->insert(without_displacements(states[i]));
      else if (held[i])
        trial.held.push_back(without_displacements(states[i]));
    }
    see_held(trial);
  }
  for (Trial& trial : parts) add_trial(std::move(trial), trials);
}

void add_groups(std::span<const State> states, std::span<const Vec3> wanted, double spacing, Trials& trials) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  const Division division = best_division(at, wanted);
  if (division.count == 0) return;
  trials.alike = division.alike;
  trials.groups += division.groups.count;
  add_division(states, division, division.groups.of, std::vector<char>(at.size(), 1), spacing, trials);
}

// Boxes of neighbouring states, at most most_boxes.
PositionGroups boxes_of(std::span<const Vec3> at) {
  std::size_t size = 1;
  while (at.size() > size * most_boxes) size *= 2;
  return compact_groups(at, size);
}

// Of each state, whether it is the first of its box.
std::vector<char> first_of(const PositionGroups& boxes) {
  std::vector<char> first, seen(boxes.count, 0);
  for (const std::uint32_t box : boxes.of) {
    first.push_back(seen[box] ? 0 : 1);
    seen[box] = 1;
  }
  return first;
}

// Many states in natural groups, as the lines of a raster: one state of each box is compared. False if there are none.
bool add_natural(std::span<const State> states, std::span<const Vec3> wanted, double spacing,
                 Trials& trials) {
  if (states.size() > most_natural) return false;
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  const std::optional<Division> division = natural_division(at, wanted);
  if (!division) return false;
  trials.groups += division->groups.count;
  add_division(states, *division, division->groups.of, first_of(boxes_of(at)), spacing, trials);
  return true;
}

// Many states: groups of boxes of neighbouring states; one state of each box is compared. False if the boxes are too
// large: farther from each other than the places are from the states.
bool add_boxes(std::span<const State> states, std::span<const Vec3> wanted, double spacing, Trials& trials) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  const PositionGroups boxes = boxes_of(at);
  std::vector<Vec3> middle(boxes.count, Vec3::Zero());
  std::vector<std::size_t> count(boxes.count, 0);
  for (std::size_t i = 0; i < at.size(); ++i) middle[boxes.of[i]] += at[i], ++count[boxes.of[i]];
  for (std::size_t b = 0; b < boxes.count; ++b) middle[b] /= static_cast<double>(count[b]);
  const Division division = best_division(middle, wanted);
  if (division.count == 0 || !division.fits()) return false;
  std::vector<std::uint32_t> group;
  for (const std::uint32_t box : boxes.of) group.push_back(division.groups.of[box]);
  trials.groups += division.groups.count;
  add_division(states, division, group, first_of(boxes), spacing, trials);
  return true;
}

// The inner half of a patch is held out: the border of a patch is not one of the states.
void add_patch(std::span<const State> states, std::span<const Vec3> wanted, double spacing, Trials& trials) {
  std::vector<Vec3> at;
  for (const State& s : states) at.push_back(s.at);
  const Division division = best_division(at, wanted);
  if (division.count == 0) return;
  trials.alike = trials.alike && division.alike;
  const PositionGroups& groups = division.groups;
  std::vector<char> used(groups.count, 1);
  for (std::size_t i = at.size() / 2 + 1; i < at.size(); ++i) used[groups.of[i]] = 0;
  trials.groups += static_cast<std::size_t>(std::ranges::count(used, 1));
  Trial trial{
      .known = std::make_unique<StateSpace>(StateSpaceOptions{.spacing = spacing}), .held = {}, .seen = {}};
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (division.part[groups.of[i]] == 0 && used[groups.of[i]])
      trial.held.push_back(without_displacements(states[i]));
    else
      trial.known->insert(without_displacements(states[i]));
  }
  add_trial(std::move(trial), trials);
}

// The patch_states states nearest to states[middle], by distance from it.
std::vector<State> patch_about(std::span<const State> states, std::size_t middle) {
  std::vector<std::size_t> order(states.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto distance = [&](std::size_t i) { return (states[i].at - states[middle].at).squaredNorm(); };
  std::ranges::nth_element(order, order.begin() + patch_states, {}, distance);
  order.resize(patch_states);
  std::ranges::stable_sort(order, {}, distance);
  std::vector<State> near;
  for (const std::size_t i : order) near.push_back(states[i]);
  return near;
}

// Patches about states that lie far from each other.
void add_patches(std::span<const State> states, std::span<const Vec3> wanted, double spacing,
                 Trials& trials) {
  std::vector<double> away(states.size(), infinite);
  std::size_t middle = 0;
  for (std::size_t patch = 0; patch < patches; ++patch) {
    add_patch(patch_about(states, middle), wanted, spacing, trials);
    for (std::size_t i = 0; i < states.size(); ++i)
      away[i] = std::min(away[i], (states[i].at - states[middle].at).squaredNorm());
    middle = static_cast<std::size_t>(std::ranges::max_element(away) - away.begin());
  }
}

// The directions in which places outside are wanted.
std::vector<Vec3> directions_of(std::span<const SeenPlace> outside) {
  std::array<std::size_t, PlaceLocator::directions> count{};
  for (const SeenPlace& place : outside) ++count[place.direction];
  std::vector<Vec3> found;
  for (std::size_t i = 0; i < count.size(); ++i)
    if (static_cast<double>(count[i]) > least_direction * static_cast<double>(outside.size()))
      found.push_back(cube_directions()[i]);
  return found;
}

// Leaves out the states within `depth` of the outermost one along u, but at most half of them.
void add_cap(std::span<const State> states, const Vec3& u, double depth, double spacing, Trials& trials) {
  const auto along = [&](const State& s) { return u.dot(s.at); };
  const auto outermost = std::ranges::max_element(states, {}, along);
  std::vector<State> patch;
  if (states.size() > most_whole) {
    patch = patch_about(states, static_cast<std::size_t>(outermost - states.begin()));
    states = patch;
  }
  std::vector<double> depths;
  for (const State& state : states) depths.push_back(along(*outermost) - along(state));
  const double limit = along(*outermost) - std::min(depth, median(std::move(depths)));
  Trial trial{
      .known = std::make_unique<StateSpace>(StateSpaceOptions{.spacing = spacing}), .held = {}, .seen = {}};
  for (const State& state : states) {
    if (along(state) > limit)
      trial.held.push_back(without_displacements(state));
    else
      trial.known->insert(without_displacements(state));
  }
  if (trial.known->size() < least_known) return;
  ++trials.groups;
  trial.cap = true;
  add_trial(std::move(trial), trials);
}

// Keeps only positions inside.
void remove_outside(Trial& trial) {
  Trial kept{.known = std::move(trial.known), .held = {}, .seen = {}};
  for (std::size_t i = 0; i < trial.held.size(); ++i) {
    if (trial.seen[i].outside) continue;
    kept.held.push_back(std::move(trial.held[i]));
    kept.seen.push_back(trial.seen[i]);
  }
  trial = std::move(kept);
}

void count_positions(Trials& trials) {
  std::erase_if(trials.each, [](const Trial& trial) { return trial.held.empty(); });
  trials.positions = 0;
  for (const Trial& trial : trials.each) trials.positions += trial.held.size();
}

void add_caps(std::span<const State> states, std::span<const SeenPlace> wanted, double spacing,
              Trials& trials) {
  std::vector<SeenPlace> outside;
  std::ranges::copy_if(wanted, std::back_inserter(outside), &SeenPlace::outside);
  if (outside.empty()) {  // borders left out with a group count as all others
    for (Trial& trial : trials.each)
      for (SeenPlace& place : trial.seen) place.outside = false;
    return;
  }
  std::vector<double> beyond;
  for (const SeenPlace& place : outside) beyond.push_back(place.beyond);
  double depth = 0.999 * median(std::move(beyond));  // a whole layer of a lattice, not two
  const std::size_t groups = trials.each.size(), counted = trials.groups;
  for (int deeper = 0; deeper < most_deeper; ++deeper, depth *= 2) {
    trials.each.resize(groups);
    trials.groups = counted;
    for (const Vec3& u : directions_of(outside)) add_cap(states, u, depth, spacing, trials);
    std::ptrdiff_t held_outside = 0;
    for (const Trial& trial : std::span(trials.each).subspan(groups))
      held_outside += std::ranges::count_if(trial.seen, &SeenPlace::outside);
    if (held_outside >= enough_outside) break;
  }
  if (trials.each.size() == groups) return;
  // Corners left out with a group are near most of their face. Caps alone show extrapolation.
  for (std::size_t t = 0; t < groups; ++t) remove_outside(trials.each[t]);
  count_positions(trials);
}

}  // namespace

PlaceLocator::PlaceLocator(const StateSpace& space) : space_(&space) {
  farthest_.fill(-infinite);
  for (std::uint32_t id = 0; id < space.size(); ++id)
    for (std::size_t k = 0; k < directions; ++k)
      farthest_[k] = std::max(farthest_[k], cube_directions()[k].dot(space[StateId{id}].at));
}

SeenPlace PlaceLocator::operator()(const Vec3& x) const {
  std::vector<StateId> nearest;
  space_->nearest(x, 1, nearest);
  const Vec3 from = x - (*space_)[nearest.front()].at;
  SeenPlace place{.away = from.norm(), .beyond = -infinite, .from = from};
  for (std::size_t k = 0; k < directions; ++k) {
    const double beyond = cube_directions()[k].dot(x) - farthest_[k];
    if (beyond > place.beyond) {
      place.beyond = beyond;
      place.direction = k;
    }
  }
  place.outside = place.beyond > 0.25 * space_->options().spacing;
  return place;
}

Trials leave_out(std::span<const State> states, std::span<const SeenPlace> wanted, double spacing) {
  Trials trials;
  std::vector<Vec3> inside;
  for (const SeenPlace& place : wanted)
    if (!place.outside) inside.push_back(place.from);
  if (states.size() <= most_whole)
    add_groups(states, inside, spacing, trials);
  else if (!add_natural(states, inside, spacing, trials) && !add_boxes(states, inside, spacing, trials))
    add_patches(states, inside, spacing, trials);
  if (!trials.each.empty()) add_caps(states, wanted, spacing, trials);
  if (!trials.each.empty() || wanted.empty()) return trials;
  trials = leave_out(states, {}, spacing);  // nothing lies so far from the rest
  trials.alike = false;
  return trials;
}

std::size_t count_beyond(std::span<const SeenPlace> held, std::span<const SeenPlace> wanted) {
  double farthest[2] = {-1, -1};
  for (const SeenPlace& h : held) farthest[h.outside] = std::max(farthest[h.outside], h.away);
  return static_cast<std::size_t>(
      std::ranges::count_if(wanted, [&](const SeenPlace& w) { return w.away > farthest[w.outside]; }));
}

std::vector<double> expected_quantiles(std::span<const double> errors, std::span<const SeenPlace> held,
                                       std::span<const SeenPlace> wanted, std::span<const double> shares) {
  std::vector<double> pooled;
  if (wanted.empty()) pooled.assign(errors.begin(), errors.end());
  const std::size_t stride = std::max<std::size_t>(1, wanted.size() / most_wanted);
  const auto doubted = [](const SeenPlace& place) { return std::isfinite(place.doubt); };
  const bool by_doubt = std::ranges::all_of(held, doubted) && std::ranges::all_of(wanted, doubted);
  for (const bool outside : {false, true}) {
    const auto depth = [&](const SeenPlace& place) {
      return by_doubt ? place.doubt : outside ? place.beyond : place.away;
    };
    std::vector<std::pair<double, double>> by_depth;  // and error
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (held[i].outside == outside) by_depth.emplace_back(depth(held[i]), errors[i]);
    if (by_depth.empty()) continue;
    std::ranges::sort(by_depth);
    const std::size_t around = outside ? std::min(beside, by_depth.size() / 4) : beside;
    const std::size_t count = std::min(2 * around + 1, by_depth.size());
    for (std::size_t i = 0; i < wanted.size(); i += stride) {
      if (wanted[i].outside != outside) continue;
      const auto at =
          std::ranges::lower_bound(by_depth, depth(wanted[i]), {}, &std::pair<double, double>::first);
      const auto rank = static_cast<std::size_t>(at - by_depth.begin());
      // Equally deep ones are ordered by their errors: all of them take part, evenly drawn.
      std::size_t first = std::min(rank > around ? rank - around : 0, by_depth.size() - count);
      std::size_t last = first + count - 1;
      while (first > 0 && by_depth[first - 1].first == by_depth[first].first) --first;
      while (last + 1 < by_depth.size() && by_depth[last + 1].first == by_depth[last].first) ++last;
      for (std::size_t k = 0; k < count; ++k)
        pooled.push_back(by_depth[first + (count > 1 ? k * (last - first) / (count - 1) : 0)].second);
    }
  }
  std::vector<double> quantiles;
  for (const double share : shares)
    quantiles.push_back(pooled.empty() ? unknown : quantile_of(pooled, share));
  return quantiles;
}

}  // namespace forefeel
