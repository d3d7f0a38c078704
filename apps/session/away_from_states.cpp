#include "apps/session/away_from_states.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
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

using Bar = std::array<double, 3>;  // ForceBar::half_width

struct Told {
  std::vector<Vec3> forces;
  std::vector<Bar> bars;  // empty: none
  // The bars about other forces there.
  std::vector<Bar> about(std::span<const Vec3> others) const {
    std::vector<Bar> wider = bars;
    for (std::size_t i = 0; i < wider.size(); ++i)
      for (double& width : wider[i]) width += (others[i] - forces[i]).norm();
    return wider;
  }
};

// What `evaluate` finds at these places.
Told told_at(std::span<const State> states, std::span<const Vec3> at, EvaluateOptions& options) {
  Evaluation found = evaluate(states, at, options);
  options.field = found.field;
  return {std::move(found.made.forces), found.bars ? found.bars->at : std::vector<Bar>()};
}

double median_bar(const std::vector<Bar>& bars) {
  std::vector<double> widths;
  for (const Bar& bar : bars) widths.push_back(bar[level]);
  const double width = widths.empty() ? unknown : median(std::move(widths));
  return std::isfinite(width) ? width : unknown;
}

// The label of the widest bars. widths: of frame `of[k]` each, the 95 % bar.
void find_worst(const std::vector<FrameRecord>& frames, std::span<const std::size_t> of,
                std::span<const double> widths, SessionSummary::AwayFromStates& away) {
  ByLabel<std::vector<double>> by_label;
  ByLabel<std::size_t> count{};
  for (const FrameRecord& frame : frames) ++count[frame.label];
  for (std::size_t k = 0; k < of.size(); ++k) by_label[frames[of[k]].label].push_back(widths[k]);
  for (const Label label : all_labels) {
    const double width = quantile_of(by_label[label], 0.95);
    if (std::isnan(width)) continue;
    if (!std::isnan(away.worst_share) && !(width > away.worst_bar)) continue;
    away.worst = label;
    away.worst_share = static_cast<double>(count[label]) / static_cast<double>(frames.size());
    away.worst_bar = width;
  }
  std::vector<double> rest;
  for (const Label label : all_labels)
    if (label != away.worst) rest.insert(rest.end(), by_label[label].begin(), by_label[label].end());
  away.rest_bar = quantile_of(rest, 0.5);
  if (!std::isfinite(away.rest_bar)) away.rest_bar = unknown;
}

// bars: of the frames `of`; a frame between two of them has the wider one.
void take_bars(std::vector<FrameRecord>& frames, const std::vector<std::size_t>& of,
               const std::vector<Bar>& bars) {
  for (std::size_t i = 0, k = 0; i < frames.size(); ++i) {
    while (k + 1 < of.size() && of[k + 1] <= i) ++k;
    const Bar& next = bars[std::min(k + 1, bars.size() - 1)];
    for (std::size_t j = 0; j < next.size(); ++j) frames[i].bar.half_width[j] = std::max(bars[k][j], next[j]);
  }
}

}  // namespace

SessionSummary::AwayFromStates away_from_states(SessionResult& result, const SessionPlan& plan,
                                                const std::function<void()>& write,
                                                const std::function<void(std::string_view, double)>& show) {
  SessionSummary::AwayFromStates away;
  std::vector<State> states;
  const bool measured = !plan.input.measured.empty();
  if (measured)  // bars of the model beside the field, not beside the truth
    for (FrameRecord& frame : result.frames) frame.bar = {};
  write();
  std::ranges::copy_if(measured ? plan.input.measured : plan.input.known, std::back_inserter(states),
                       &State::usable);
  if (!plan.input.foreign || plan.input.touched.anywhere || states.empty() || result.frames.empty())
    return away;
  std::vector<double> distances;
  const std::size_t stride = 1 + result.frames.size() / most_compared;
  for (std::size_t i = 0; i < result.frames.size(); i += stride) {
    double least = std::numeric_limits<double>::infinity();
    for (const State& state : states) least = std::min(least, (state.at - result.frames[i].at).squaredNorm());
    distances.push_back(std::sqrt(least));
  }
  away.farthest = *std::ranges::max_element(distances);
  away.median = median(std::move(distances));
  const std::vector<std::size_t> picked = evenly(result.frames.size());
  std::vector<Bar> bars, modelled_bars;
  try {
    if (states.size() <= most_known) {
      std::vector<Vec3> hand, modelled, rendered, known;
      for (const std::size_t i : picked) {
        hand.push_back(result.frames[i].at);
        modelled.push_back(result.frames[i].undamped);
        rendered.push_back(result.frames[i].elastic);
      }
      for (const std::size_t i : evenly(states.size())) known.push_back(states[i].at);
      EvaluateOptions options{.bars = true, .field = plan.input.measured_field, .show = show};
      const Told told = told_at(states, hand, options);
      modelled_bars = told.about(modelled);
      away.bar = median_bar(modelled_bars);
      away.bar_at_states = median_bar(told_at(states, known, options).bars);
      bars = told.about(rendered);
    }
  } catch (const InputError&) {  // states that no model takes
  }
  if (bars.empty()) return away;
  // Of measured states, all frames have a bar, as frames.csv has them; of others, the picked ones.
  std::vector<std::size_t> of = picked;
  std::vector<double> widths;
  if (measured) {
    take_bars(result.frames, picked, bars);
    write();
    of.resize(result.frames.size());
    std::iota(of.begin(), of.end(), std::size_t{0});
    for (const FrameRecord& frame : result.frames) widths.push_back(frame.bar.half_width[level]);
  } else {
    for (const Bar& bar : modelled_bars) widths.push_back(bar[level]);
  }
  find_worst(result.frames, of, widths, away);
  return away;
}

}  // namespace forefeel
