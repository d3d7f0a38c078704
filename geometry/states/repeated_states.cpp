#include "geometry/states/repeated_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

using Indices = std::vector<std::size_t>;

// Site and displacement; zeros stand for a missing site.
std::array<double, 6> position_of(const State& s) {
  const Vec3 site = s.has_site() ? s.site : Vec3(Vec3::Zero());
  return {site.x(), site.y(), site.z(), s.at.x(), s.at.y(), s.at.z()};
}

// Calls visit(indices) for each position, the states of a position in their order.
template <class Visit>
void for_each_position(std::span<const State> states, Visit&& visit) {
  Indices order(states.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto position = [&](std::size_t i) { return position_of(states[i]); };
  std::ranges::stable_sort(order, {}, position);
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && position(order[end]) == position(order[begin])) ++end;
    visit(std::span(order).subspan(begin, end - begin));
    begin = end;
  }
}

// The usable states of a position if one contradicts the first; else nothing.
Indices contradicting(std::span<const State> states, std::span<const std::size_t> here) {
  Indices usable;
  std::ranges::copy_if(here, std::back_inserter(usable), [&](std::size_t i) { return states[i].usable(); });
  const bool any = std::ranges::any_of(
      usable, [&](std::size_t i) { return contradict(states[usable.front()], states[i]); });
  return any ? usable : Indices();
}

void count(std::span<const State> states, std::span<const std::size_t> here, RepeatedStates& found) {
  found.repeated += here.size() - 1;
  const Indices differing = contradicting(states, here);
  if (differing.empty()) return;
  ++found.averaged;
  for (std::size_t i = 0; i < differing.size(); ++i) {
    found.contradicting += contradict(states[differing.front()], states[differing[i]]) ? 1 : 0;
    for (std::size_t j = 0; j < std::min<std::size_t>(i, 1000); ++j)
      found.largest_difference = std::max(found.largest_difference,
                                          (states[differing[i]].force - states[differing[j]].force).norm());
  }
}

// Mean of the known values; NaN where none is known.
class Mean {
 public:
  explicit Mean(const State& first) : state_(first) {
    state_.force.setZero();
    state_.stiffness.setZero();
    state_.energy = 0;
    state_.displacements.reset();
    state_.jet.reset();  // each is about the force that its own state has
    state_.solve.status = SolveStatus::measured;
  }
  void add(const State& s) {
    state_.force += s.force, ++forces_;
    if (s.has_stiffness()) state_.stiffness += s.stiffness, ++stiffnesses_;
    if (s.energy == s.energy) state_.energy += s.energy, ++energies_;
  }
  State state() const {
    State mean = state_;
    mean.force /= forces_;
    mean.stiffness = stiffnesses_ > 0 ? Mat3(state_.stiffness / stiffnesses_) : Mat3(Mat3::Constant(unknown));
    mean.energy = energies_ > 0 ? state_.energy / energies_ : unknown;
    return mean;
  }

 private:
  State state_;
  double forces_ = 0, stiffnesses_ = 0, energies_ = 0;
};

// How far forces are from the mean of their position.
class Scatter {
 public:
  void add(std::span<const State> states, const Indices& here, const Vec3& mean) {
    for (const std::size_t i : here) off_.push_back((states[i].force - mean).norm());
    freedom_ += 3 * (static_cast<double>(here.size()) - 1);
    ++positions_;
  }
  void report(RepeatedStates& found) const {
    if (off_.empty()) return;
    double squared = 0;
    for (const double off : off_) squared += off * off;
    found.off_mean = quantile_of(off_, 0.95);
    found.mean_noise = std::sqrt(squared / freedom_ * positions_ / static_cast<double>(off_.size()));
  }

 private:
  std::vector<double> off_;
  double freedom_ = 0, positions_ = 0;
};

}  // namespace

bool contradict(const State& a, const State& b) {
  return a.usable() && b.usable() &&
         (a.force - b.force).norm() > 1e-6 * std::max(a.force.norm(), b.force.norm());
}

RepeatedStates repeated_states(std::span<const State> states) {
  RepeatedStates found;
  for_each_position(states, [&](std::span<const std::size_t> here) { count(states, here, found); });
  return found;
}

std::string contradictions_in_words(const std::string& file, const RepeatedStates& found) {
  if (found.contradicting == 0) return {};
  return fmt::format(
      "{}: {} another at the same position: averaged at {}, where forces differ by up to {:.4g} N", file,
      found.contradicting == 1 ? "1 state contradicts"
                               : fmt::format("{} states contradict", found.contradicting),
      found.averaged == 1 ? "1 position" : fmt::format("{} positions", found.averaged),
      found.largest_difference);
}

AveragedStates averaged(std::vector<State> states) {
  AveragedStates result;
  std::vector<char> drop(states.size(), 0);
  std::vector<std::pair<std::size_t, State>> means;
  Scatter scatter;
  for_each_position(states, [&](std::span<const std::size_t> here) {
    count(states, here, result.found);
    const Indices differing = contradicting(states, here);
    if (differing.empty()) return;
    Mean mean(states[differing.front()]);
    for (const std::size_t i : differing) {
      mean.add(states[i]);
      drop[i] = 1;
    }
    means.emplace_back(differing.front(), mean.state());
    scatter.add(states, differing, means.back().second.force);
  });
  scatter.report(result.found);
  if (means.empty()) {
    result.states = std::move(states);
    return result;
  }
  for (auto& [i, mean] : means) {
    states[i] = std::move(mean);
    drop[i] = 0;
  }
  result.states.reserve(states.size());
  for (std::size_t i = 0; i < states.size(); ++i)
    if (!drop[i]) result.states.push_back(std::move(states[i]));
  return result;
}

}  // namespace forefeel
