#include "approx/error/error_bar.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "approx/error/error_scale.hpp"
#include "approx/error/place_models.hpp"
#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

constexpr double no_bar = std::numeric_limits<double>::infinity();
constexpr std::size_t least_states = 8, least_checks = 20, least_of_label = 30, most_samples = 800;
constexpr double constants[] = {0, 0.1, 0.3, 1, 3};  // b, in median errors
constexpr std::size_t scored_level = 1;              // of bar_levels: 95 %
constexpr std::size_t least_safe = 20;
constexpr double within_share = 0.95, wider = 1.5;

// The ceil((n + 1) p)-th least of n scores; no_bar if there are fewer.
double conformal_quantile(std::vector<double>& scores, double p) {
  const auto rank = static_cast<std::size_t>(std::ceil((static_cast<double>(scores.size()) + 1) * p - 1e-9));
  if (rank > scores.size()) return no_bar;
  const auto at = scores.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::ranges::nth_element(scores, at);
  return *at;
}

// The smallest score at which the summed weight of all scores up to it reaches `share` of the total.
double weighted_quantile(const std::vector<std::pair<double, double>>& sorted, double total, double share) {
  if (share >= 1) return 2 * sorted.back().first;
  double sum = 0;
  for (const auto& [score, weight] : sorted) {
    sum += weight;
    if (sum >= share * total) return score;
  }
  return sorted.back().first;
}

// Of sessions that touch a body anywhere, |F - f| over the estimate: quantiles over the 1,400 samples above the floor
// of 25 sessions whose bodies, laws, motions and costs of a solve were drawn at random; tests/bench/error_bar_prior.py
// draws others and checks the bars.
constexpr double touch_prior[] = {0.066, 0.066, 0.076, 0.096, 0.12, 0.14, 0.17, 0.19, 0.22, 0.24,
                                  0.26,  0.29,  0.31,  0.34,  0.37, 0.39, 0.42, 0.45, 0.48, 0.51,
                                  0.55,  0.59,  0.63,  0.67,  0.71, 0.76, 0.81, 0.86, 0.93, 1,
                                  1.1,   1.2,   1.3,   1.5,   1.7,  1.9,  2.3,  2.9,  4.1,  6.4};

using Factors = std::array<ByLabel<BarFactors>, 2>;

// The scores of samples inside (0) and outside (1), of each label and of all.
struct Scores {
  std::array<ByLabel<std::vector<double>>, 2> of_label;
  std::array<std::vector<double>, 2> all;
};

Scores scores_of(std::span<const BarSample> samples, double constant, std::optional<std::uint32_t> but) {
  Scores scores;
  for (const BarSample& s : samples) {
    if (but == s.part) continue;
    const double score = s.error > 0 ? s.error / (s.scale + constant) : 0;
    scores.all[s.seen.outside].push_back(score);
    scores.of_label[s.seen.outside][s.label].push_back(score);
  }
  return scores;
}

// Factors q inside and outside, of each label, from all samples except those of part `but`.
Factors factors_of(std::span<const BarSample> samples, double constant, std::optional<std::uint32_t> but) {
  Scores scores = scores_of(samples, constant, but);
  std::vector<double> every = scores.all[0];
  every.insert(every.end(), scores.all[1].begin(), scores.all[1].end());
  const double most_outside = scores.all[1].empty() ? 0 : *std::ranges::max_element(scores.all[1]);
  Factors factors;
  for (const bool outside : {false, true})
    for (const Label label : all_labels)
      for (std::size_t level = 0; level < bar_levels.size(); ++level) {
        std::vector<double>& own = scores.of_label[outside][label];
        double& q = factors[outside][label][level] = no_bar;
        if (own.size() >= least_of_label) q = conformal_quantile(own, bar_levels[level]);
        if (std::isinf(q)) q = conformal_quantile(scores.all[outside], bar_levels[level]);
        if (std::isinf(q) && !outside) q = conformal_quantile(every, bar_levels[level]);
        // Too few outside: at least the worst of them. The bar of a sample itself is then not known.
        if (std::isinf(q) && outside && !but)
          q = std::max(most_outside, conformal_quantile(every, bar_levels[level]));
        if (level > 0) q = std::max(q, factors[outside][label][level - 1]);
      }
  return factors;
}

BarWidths times(BarFactors factors, double scale) {
  for (double& q : factors) q *= scale;
  return factors;
}

// Bars of each sample from the scores of the other parts.
void fill_bars(std::vector<BarSample>& samples, double constant) {
  std::uint32_t parts = 0;
  for (const BarSample& s : samples) parts = std::max(parts, s.part + 1);
  for (std::uint32_t part = 0; part < parts; ++part) {
    const Factors factors = factors_of(samples, constant, part);
    for (BarSample& s : samples)
      if (s.part == part) s.bar = times(factors[s.seen.outside][s.label], s.scale + constant);
  }
}

// Sum of the interval scores of the 95 % bars: the width of each, plus 2 / 0.05 times the excess of the error over the
// half-width.
double interval_score(std::span<const BarSample> samples) {
  double sum = 0;
  for (const BarSample& s : samples) {
    const double bar = s.bar[scored_level];
    sum += 2 * bar + 2 / (1 - bar_levels[scored_level]) * std::max(0.0, s.error - bar);
  }
  return sum;
}

template <class Counts>
BarCover cover_of(std::span<const BarSample> samples, Counts counts) {
  BarCover found;
  std::array<std::size_t, bar_levels.size()> inside{}, known{};
  std::vector<double> widths;
  for (const BarSample& s : samples) {
    if (!counts(s)) continue;
    ++found.samples;
    widths.push_back(s.bar[scored_level]);
    for (std::size_t level = 0; level < inside.size(); ++level) {
      known[level] += std::isfinite(s.bar[level]);
      inside[level] += std::isfinite(s.bar[level]) && s.error <= s.bar[level];
    }
  }
  if (found.samples == 0) return found;
  for (std::size_t level = 0; level < inside.size(); ++level)
    if (known[level] > 0)
      found.inside[level] = static_cast<double>(inside[level]) / static_cast<double>(known[level]);
  found.width_p50 = median(std::move(widths));
  return found;
}

PlaceMethod method_of(const OfflineBarOptions& options) {
  return {.model = options.model, .all = options.all, .field = options.field, .judge = options.judge};
}

BarSample sample_of(const StateSpace& known, const Vec3& force, const State& held) {
  const Coverage coverage = known.coverage(held.at);
  return {.at = held.at,
          .force = held.force.norm(),
          .predicted = force.norm(),
          .label = coverage.label,
          .spread = coverage.spread,
          .seen = {.away = coverage.delta},
          .scale = scale_at(known, held.at, force),
          .error = (force - held.force).norm()};
}

// Every `stride`-th force left out of one trial.
std::vector<BarSample> samples_of(const Trial& trial, std::uint32_t part, const OfflineBarOptions& options,
                                  std::size_t stride) {
  PlaceForces forces(*trial.known, method_of(options));
  std::vector<BarSample> samples;
  for (std::size_t i = part % stride; i < trial.held.size(); i += stride) {
    const PlaceForces::Found found = forces.at(trial.held[i].at);
    BarSample sample = sample_of(*trial.known, found.force, trial.held[i]);
    if (found.judged) {
      sample.scale = found.judged->scale_of(found.force);
      sample.across = found.judged->least_error;
    }
    sample.seen = trial.seen[i];
    sample.part = part;
    if (std::isfinite(sample.scale) && std::isfinite(sample.error)) samples.push_back(sample);
  }
  return samples;
}

}  // namespace

// Quantiles of sqrt(max(0, ||F - f||^2 - r^2)) / s over the samples of 23 sessions whose bar of 95 % was above its
// floor: bodies, laws, contacts, motions and costs of a solve were drawn at random for most of them. F [N]: rendered
// force, f [N]: force of a tight solve, r [N]: difference between rendered and model force that the switch has not yet
// removed. `tests/bench/error_bar_prior.py prior` prints them; `check` tests how well bars cover in other sessions.
// Left out in turn, each of the 23 sessions judged by the others: bars of 90, 95 and 99 % held 89, 94 and 98 % above
// the floor.
std::array<PriorScores, 4> grasp_prior() {
  return {{
      // safe: 1062 scores
      {{0.00172, 0.0194, 0.0465, 0.0774, 0.102, 0.123, 0.158, 0.198, 0.257, 0.311, 0.4, 0.462, 0.507, 0.609,
        0.768, 2.81}},
      // sparse: 1615 scores
      {{0.00677, 0.0304, 0.0766, 0.145, 0.215, 0.265, 0.346, 0.41, 0.532, 0.608, 0.765, 0.827, 0.873, 0.995,
        1.18, 5.71}},
      // gap: 213 scores, of an earlier measurement
      {{0.00516, 0.0224, 0.0459, 0.0712, 0.0975, 0.12, 0.187, 0.21, 0.228, 0.238, 0.261, 0.273, 0.355, 0.383,
        0.403, 0.554}},
      // blank: 502 scores
      {{0.00796, 0.0433, 0.108, 0.234, 0.299, 0.347, 0.546, 0.725, 0.997, 1.18, 1.3, 1.42, 1.44, 1.57, 2.06,
        3.73}},
  }};
}

ConformalFactors::ConformalFactors(ConformalOptions options) : options_(options) {
  for (const Label label : all_labels) {
    for (std::size_t i = 0; i < bar_levels.size(); ++i) tracks_[index(label)].miss[i] = 1 - bar_levels[i];
    update(label);
  }
}

void ConformalFactors::learn(Label label, double score, double weight) {
  if (!std::isfinite(score)) return;
  Track& track = tracks_[index(label)];
  for (std::size_t i = 0; i < bar_levels.size(); ++i) {
    const double missed = score > track.factors[i] ? 1 : 0;
    const double next = track.miss[i] + weight * options_.gamma * (1 - bar_levels[i] - missed);
    track.miss[i] = std::clamp(next, -options_.gamma, 1.0);
  }
  if (track.scores.size() == options_.window) track.scores.pop_front();
  track.scores.push_back({score, weight});
  update(label);
}

void ConformalFactors::update(Label label) {
  Track& track = tracks_[index(label)];
  std::vector<std::pair<double, double>> sorted;
  double total = 0;
  const auto add = [&](double score, double weight) {
    sorted.emplace_back(score, weight);
    total += weight;
  };
  if (options_.prior) {
    double below = 0;
    for (std::size_t i = 0; i < prior_shares.size(); ++i) {
      add((*options_.prior)[index(label)][i], options_.prior_weight * (prior_shares[i] - below));
      below = prior_shares[i];
    }
  }
  for (const Score& score : track.scores) add(score.value, score.weight);
  if (sorted.empty()) return;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < bar_levels.size(); ++i) {
    track.factors[i] = weighted_quantile(sorted, total, 1 - track.miss[i]);
    // Levels stay in order: a wider one is never narrower.
    if (i > 0) track.factors[i] = std::max(track.factors[i], track.factors[i - 1]);
  }
}

// As long as there are too few scores for a level, the largest.
BarFactors touch_bar_factors(const std::vector<double>& scores) {
  std::vector<double> all(std::begin(touch_prior), std::end(touch_prior));
  all.insert(all.end(), scores.begin(), scores.end());
  const double largest = std::ranges::max(all);
  BarFactors factors{};
  for (std::size_t i = 0; i < factors.size(); ++i)
    factors[i] = std::min(conformal_quantile(all, bar_levels[i]), largest);
  return factors;
}

OfflineBars::OfflineBars(std::vector<BarSample> samples) : samples_(std::move(samples)) {
  if (samples_.empty()) return;
  std::vector<double> errors;
  for (const BarSample& s : samples_) errors.push_back(s.error);
  const double usual = median(std::move(errors));
  double best = no_bar;
  for (const double share : constants) {
    fill_bars(samples_, share * usual);
    const double score = interval_score(samples_);
    if (score < best) {
      best = score;
      constant_ = share * usual;
    }
  }
  fill_bars(samples_, constant_);
  factors_ = factors_of(samples_, constant_, {});
}

BarWidths OfflineBars::at(const BarPlace& place) const {
  if (samples_.empty() || !(place.scale >= 0)) return unknown_factors();
  BarWidths widths = judged_ ? times(judge_.quantiles, deviation(place))
                             : times(factors_[place.outside][place.label], place.scale + constant_);
  widen(widths, place.across);
  return widths;
}

BarCover OfflineBars::cover(std::optional<Label> label) const {
  return cover_of(samples_, [&](const BarSample& s) { return !label || s.label == *label; });
}

BarCover OfflineBars::cover_outside() const {
  return cover_of(samples_, [](const BarSample& s) { return s.seen.outside; });
}

OfflineBars measure_bars(std::span<const State> states, const OfflineBarOptions& options) {
  if (states.size() < least_states) return {};
  const Trials trials = leave_out(states, options.wanted, options.spacing);
  const std::size_t stride = std::max<std::size_t>(1, trials.positions / most_samples);
  std::vector<std::vector<BarSample>> parts(trials.each.size());
  std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t t = 0; t < parts.size(); ++t) {
    parts[t] = samples_of(trials.each[t], static_cast<std::uint32_t>(t), options, stride);
    std::size_t now = 0;
#pragma omp atomic capture
    now = ++done;
    if (options.show && omp_get_thread_num() == 0)
      options.show(static_cast<double>(now) / static_cast<double>(parts.size()));
  }
  std::vector<BarSample> samples;
  for (const std::vector<BarSample>& part : parts) samples.insert(samples.end(), part.begin(), part.end());
  if (options.judge)
    return {std::move(samples), {.noise = options.judge->law.noise, .groups = trials.groups}};
  return OfflineBars(std::move(samples));
}

double checked_scale(const Vec3& force) {
  return std::max(force.norm(), Tolerance().floor);
}

OfflineBars checked_bars(const StateSpace& known, std::span<const State> checks,
                         const OfflineBarOptions& options) {
  OfflineBars bars;
  if (checks.size() < least_checks || known.empty()) return bars;
  PlaceForces models(known, method_of(options));
  std::vector<double> scores;
  for (std::size_t i = 0; i < checks.size(); ++i) {
    BarSample sample = sample_of(known, models.at(checks[i].at).force, checks[i]);
    sample.scale = std::max(sample.predicted, Tolerance().floor);
    sample.part = static_cast<std::uint32_t>(i);
    if (!std::isfinite(sample.error)) continue;
    bars.samples_.push_back(sample);
    scores.push_back(sample.error / sample.scale);
  }
  std::vector<double> others;
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    for (auto& of_labels : bars.factors_)
      for (BarWidths& factors : of_labels.values)
        factors[level] = quantile_of(scores, bar_levels[level], QuantileRule::inverted_cdf);
    for (std::size_t i = 0; i < scores.size(); ++i) {  // each with the factor of the others
      others = scores;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      bars.samples_[i].bar[level] =
          bars.samples_[i].scale * quantile_of(others, bar_levels[level], QuantileRule::inverted_cdf);
    }
  }
  bars.checked_ = true;
  return bars;
}

double scale_at(const StateSpace& space, const Vec3& x, const Vec3& force) {
  std::vector<StateId> ids;
  space.nearest(x, ErrorScale::most, ids);
  std::vector<State> near;
  for (const StateId id : ids) near.push_back(space[id]);
  return ErrorScale(near, space.options().spacing).at(x, force);
}

KnownWithin known_within(std::span<const BarSample> samples, const Tolerance& tolerance) {
  KnownWithin found{.samples = samples.size()};
  for (const BarSample& s : samples) {
    if (!(s.bar[1] <= tolerance.limit(s.predicted))) continue;
    ++found.called;
    found.true_ones += s.error <= tolerance.limit(s.force) ? 1 : 0;
  }
  return found;
}

SpacingAdvice advise_spacing(std::span<const BarSample> samples, const Tolerance& tolerance,
                             double safe_spread) {
  std::vector<std::pair<double, bool>> by_spread;  // spread, within
  for (const BarSample& s : samples)
    if (std::isfinite(s.spread)) by_spread.emplace_back(s.spread, s.error <= tolerance.limit(s.force));
  std::ranges::sort(by_spread, {}, &std::pair<double, bool>::first);
  SpacingAdvice advice;
  std::size_t within = 0;
  for (std::size_t i = 0; i < by_spread.size(); ++i) {
    within += by_spread[i].second ? 1 : 0;
    const bool last = i + 1 == by_spread.size();
    if (!last && by_spread[i + 1].first <= by_spread[i].first * (1 + 1e-9))
      continue;  // equal spreads count together
    if (i + 1 < least_safe || static_cast<double>(within) < within_share * static_cast<double>(i + 1))
      continue;
    advice = {.spacing = by_spread[i].first / safe_spread, .safe = i + 1, .within = within, .all = last};
  }
  for (std::size_t i = advice.safe; i < by_spread.size() && !std::isnan(advice.spacing); ++i) {
    if (by_spread[i].first > wider * safe_spread * advice.spacing) break;
    ++advice.wider;
    advice.wider_within += by_spread[i].second ? 1 : 0;
  }
  return advice;
}

}  // namespace forefeel
