#include "apps/session/away_from_states.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

#include "approx/methods/evaluate.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {
namespace {

constexpr std::size_t most_bars = 100;       // places at which bars are made, each
constexpr std::size_t most_compared = 5000;  // whose distances are taken
constexpr std::size_t most_known = 20'000;   // states; with more the choice of a model takes minutes
constexpr std::size_t level = 1;             // of bar_levels: 95 %

// Every so many of n, at most `most_bars` of them.
std::vector<std::size_t> evenly(std::size_t n) {
  const std::size_t count = std::min(n, most_bars);
  std::vector<std::size_t> picked;
  for (std::size_t k = 0; k < count; ++k) picked.push_back(k * n / count);
  return picked;
}

// rendered: forces there, or none.
double median_bar(std::span<const State> states, std::span<const Vec3> at, std::span<const Vec3> rendered) {
  const Evaluation found = evaluate(states, at, {.bars = true});
  if (!found.bars) return unknown;
  std::vector<double> widths;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double off = rendered.empty() ? 0 : (rendered[i] - found.made.forces[i]).norm();
    widths.push_back(found.bars->at[i][level] + off);
  }
  const double width = median(std::move(widths));
  return std::isfinite(width) ? width : unknown;
}

}  // namespace

SessionSummary::AwayFromStates away_from_states(const SessionResult& result, const SessionPlan& plan) {
  SessionSummary::AwayFromStates away;
  std::vector<State> states;
  const bool measured = !plan.input.measured.empty();
  std::ranges::copy_if(measured ? plan.input.measured : plan.input.known, std::back_inserter(states), &State::usable);
  if (!plan.input.foreign || states.empty() || result.frames.empty()) return away;
  std::vector<double> distances;
  const std::size_t stride = 1 + result.frames.size() / most_compared;
  for (std::size_t i = 0; i < result.frames.size(); i += stride) {
    double least = std::numeric_limits<double>::infinity();
    for (const State& state : states) least = std::min(least, (state.at - result.frames[i].at).squaredNorm());
    distances.push_back(std::sqrt(least));
  }
  away.farthest = *std::ranges::max_element(distances);
  away.median = median(std::move(distances));
  if (states.size() > most_known) return away;
  std::vector<Vec3> hand, rendered, known;
  for (const std::size_t i : evenly(result.frames.size())) {
    hand.push_back(result.frames[i].at);
    rendered.push_back(result.frames[i].force);
  }
  for (const std::size_t i : evenly(states.size())) known.push_back(states[i].at);
  try {
    away.bar = median_bar(states, hand, rendered);
    away.bar_at_states = median_bar(states, known, {});
  } catch (const InputError&) {  // states that no model takes
  }
  return away;
}

}  // namespace forefeel
