#include "geometry/states/repeated_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "geometry/common/quantiles.hpp"
#include "geometry/states/hysteresis.hpp"

namespace forefeel {
namespace {

constexpr double same = 1e-9;           // of the largest value: two values that differ by less are one
constexpr double off_grid = 0.02;       // of a step, that a value may be off a multiple
constexpr double most_multiples = 1e5;  // a finer grid than this part of the range is none
constexpr std::size_t fewest_gaps = 2;  // that show a step
constexpr double least_noise = 0.02, most_noise = 0.5;  // of rounded forces, in steps
constexpr double by_chance = 0.5;                       // of the noise of means: less is not chance
constexpr double enough_repeated = 0.1;                 // share of the positions
constexpr std::size_t fewest_repeated = 8;

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

// The step whose multiples all values are; 0: none.
double step_of(std::vector<double> values) {
  std::ranges::sort(values);
  const double range = std::max(std::abs(values.front()), std::abs(values.back()));
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double gap = values[i] - values[i - 1]; gap > same * range) gaps.push_back(gap);
  if (gaps.size() < fewest_gaps) return 0;
  const double step = std::ranges::min(gaps);
  if (step * most_multiples < range) return 0;
  const auto fits = [step](double value) {
    return std::abs(value / step - std::round(value / step)) <= off_grid;
  };
  return std::ranges::all_of(gaps, fits) ? step : 0;
}

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

std::string contradictions_in_words(const std::string& file, const RepeatedStates& found,
                                    std::span<const State> states) {
  if (found.contradicting == 0 || hysteresis_of(states)) return {};
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

SharedError shared_error(std::span<const State> rows, const RepeatedStates& repeated, double noise) {
  Vec3 step = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const State& row : rows)
      if (row.usable()) values.push_back(row.force[k]);
    if (!values.empty()) step[k] = step_of(std::move(values));
  }
  SharedError found{.step = step.norm()};
  if (noise > least_noise * found.step && noise < most_noise * found.step) found.rounding = 0.5 * found.step;
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(rows, &State::usable));
  const std::size_t positions = usable - std::min(usable, repeated.repeated);
  const bool often = repeated.averaged >= fewest_repeated &&
                     double(repeated.averaged) >= enough_repeated * double(positions);
  if (often && noise < by_chance * repeated.mean_noise) found.courses = repeated.off_mean;
  return found;
}

}  // namespace forefeel
