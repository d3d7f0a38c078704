#include "approx/error/offline_bar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "approx/error/error_scale.hpp"
#include "approx/error/judged_factors.hpp"
#include "approx/error/place_models.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/common/tolerance.hpp"

namespace forefeel {
namespace {

constexpr double no_bar = std::numeric_limits<double>::infinity();
constexpr std::size_t least_states = 8, least_checks = 20, least_of_label = 30, most_samples = 800;
constexpr double constants[] = {0, 0.1, 0.3, 1, 3};  // b, in median errors
constexpr std::size_t scored_level = 1;              // of bar_levels: 95 %
constexpr std::size_t local_samples = 30;
constexpr double calm_share = 0.1;  // of the samples, in whose neighbourhoods errors are noise alone
constexpr BarWidths steeper{2, across_of_95,
                            4};  // stiffness across the states, in largest stiffnesses along them
double square(double x) {
  return x * x;
}

// The ceil((n + 1) p)-th least of n scores; no_bar if there are fewer.
double conformal_quantile(std::vector<double>& scores, double p) {
  const auto rank = static_cast<std::size_t>(std::ceil((static_cast<double>(scores.size()) + 1) * p - 1e-9));
  if (rank > scores.size()) return no_bar;
  const auto at = scores.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::ranges::nth_element(scores, at);
  return *at;
}

using Factors = std::array<ByLabel<BarWidths>, 2>;

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

BarWidths times(BarWidths factors, double scale) {
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

// r: how much more s shrinks from the held-out positions to the wanted places than the squares of their distances do.
double shrinkage_of(std::span<const BarSample> samples, const OfflineBarOptions& options) {
  double held_squared = 0, wanted_squared = 0;
  std::vector<double> held_away, wanted_away;
  for (const BarSample& s : samples) {
    if (s.seen.outside) continue;
    held_squared += square(s.scale);
    held_away.push_back(s.seen.away);
  }
  for (std::size_t i = 0; i < options.scales.size(); ++i) {
    if (options.wanted[i].outside || !std::isfinite(options.scales[i])) continue;
    wanted_squared += square(options.scales[i]);
    wanted_away.push_back(options.wanted[i].away);
  }
  if (held_away.empty() || !(wanted_squared > 0)) return 1;
  const double held = std::sqrt(held_squared / static_cast<double>(held_away.size()));
  const double here = std::sqrt(wanted_squared / static_cast<double>(wanted_away.size()));
  const double farther = median(std::move(held_away)), nearer = median(std::move(wanted_away));
  return nearer > 0 ? std::max(1.0, held / here / square(std::max(1.0, farther / nearer))) : 1;
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
      sample.scale = judged_scale(*found.judged, found.force);
      sample.across = found.judged->least_error;
    }
    sample.seen = trial.seen[i];
    sample.part = part;
    if (std::isfinite(sample.scale) && std::isfinite(sample.error)) samples.push_back(sample);
  }
  return samples;
}

}  // namespace

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

void widen(BarWidths& widths, double across) {
  for (std::size_t level = 0; level < widths.size(); ++level) widths[level] += steeper[level] * across;
}

// The samples become those of judged bars: their scale is that of a comparison with a measured force.
OfflineBars::OfflineBars(std::vector<BarSample> samples, double noise, std::size_t groups, double shrinkage)
    : samples_(std::move(samples)) {
  if (samples_.empty()) return;
  Judge& judge = judge_;
  judge.noise = 3 * square(noise);
  std::vector<Misfit> of_part;
  Misfit every;
  std::vector<double> excess;
  for (const BarSample& s : samples_) {
    const double own = square(s.scale), seen = own + judge.noise;
    excess.push_back(std::max(0.0, s.error - steeper[scored_level] * s.across));
    judge.misses.push_back(seen > 0 ? square(excess.back()) / seen : 0);
    const Misfit one{.samples = 1, .share = seen > 0 ? own / seen : 0};
    if (of_part.size() <= s.part) of_part.resize(s.part + 1);
    for (Misfit* sum : {&of_part[s.part], &every})
      sum->add({one.samples, one.share, one.share * judge.misses.back()});
  }
  const double each = std::min(1.0, static_cast<double>(groups) / every.samples);  // groups of a sample
  find_locality(each);
  std::vector<Misfit> others;
  for (const Misfit& part : of_part)
    others.push_back({every.samples - part.samples, every.share - part.share, every.missed - part.missed});
  std::vector<double> scores;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    BarSample& s = samples_[i];
    s.scale = std::sqrt(variance(s.scale, trust_of(others[s.part], each), local(s.at, s.part)) + judge.noise);
    scores.push_back(s.scale > 0 ? excess[i] / s.scale : 0);
  }
  for (std::uint32_t part = 0; part < others.size(); ++part) {
    std::vector<double> other_scores;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      if (samples_[i].part != part) other_scores.push_back(scores[i]);
    const BarWidths factors = judged_factors(std::move(other_scores), each, others[part].share);
    for (BarSample& s : samples_) {
      if (s.part != part) continue;
      s.bar = times(factors, s.scale);
      widen(s.bar, s.across);
    }
  }
  judge.trust = trust_of(every, each, shrinkage);
  judge.quantiles = judged_factors(std::move(scores), each, every.share);
}

// B and T0 from the local means at the samples themselves.
void OfflineBars::find_locality(double each) {
  Judge& judge = judge_;
  for (const double y : judge.misses) judge.mean += y / static_cast<double>(judge.misses.size());
  if (!(judge.mean > 0)) return;
  judge.locality = 1;
  std::vector<double> ratios;
  double spread = 0;
  for (const BarSample& s : samples_) {
    ratios.push_back(local(s.at, {}));
    spread += square(ratios.back() - 1) / static_cast<double>(samples_.size());
  }
  const double count = static_cast<double>(std::min(local_samples, samples_.size()));
  const double by_chance = 2 / (3 * std::max(1.0, count * std::min(1.0, each)));
  judge.locality = spread > by_chance ? 1 - by_chance / spread : 0;
  const double calm = quantile_of(ratios, calm_share);
  judge.calm = judge.mean * (1 + judge.locality * (calm - 1));
}

double OfflineBars::local(const Vec3& x, std::optional<std::uint32_t> but) const {
  if (!(judge_.locality > 0)) return 1;
  std::vector<std::pair<double, double>> near;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    if (samples_[i].part != but) near.emplace_back((samples_[i].at - x).squaredNorm(), judge_.misses[i]);
  if (near.empty()) return 1;
  const std::size_t count = std::min(local_samples, near.size());
  std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(count - 1));
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) sum += near[k].second;
  return 1 + judge_.locality * (sum / (static_cast<double>(count) * judge_.mean) - 1);
}

double OfflineBars::variance(double scale, double trust, double local) const {
  const double own = square(scale);
  const double missed = judge_.mean * local * (own + judge_.noise) - judge_.calm * judge_.noise;
  return std::max(std::max(1.0, square(trust) * local) * own, missed);
}

BarWidths OfflineBars::at(Label label, bool outside, double scale) const {
  BarWidths none;
  none.fill(no_bar);
  if (samples_.empty() || !(scale >= 0)) return none;
  return times(factors_[outside][label], scale + constant_);
}

BarWidths OfflineBars::at(const Vec3& x, double scale, double across) const {
  BarWidths widths;
  widths.fill(no_bar);
  if (samples_.empty() || !(scale >= 0)) return widths;
  widths = times(judge_.quantiles, std::sqrt(variance(scale, judge_.trust, local(x, {}))));
  widen(widths, across);
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
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t t = 0; t < parts.size(); ++t)
    parts[t] = samples_of(trials.each[t], static_cast<std::uint32_t>(t), options, stride);
  std::vector<BarSample> samples;
  for (const std::vector<BarSample>& part : parts) samples.insert(samples.end(), part.begin(), part.end());
  if (options.judge) {
    const double shrinkage = shrinkage_of(samples, options);
    return {std::move(samples), options.judge->law.noise, trials.groups, shrinkage};
  }
  return OfflineBars(std::move(samples));
}

void keep_together(std::span<BarWidths> bars, std::span<const char> counts, double times) {
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    double widest = 0;
    for (std::size_t i = 0; i < bars.size(); ++i)
      if (counts[i] && std::isfinite(bars[i][level])) widest = std::max(widest, bars[i][level]);
    for (BarWidths& bar : bars) bar[level] = std::max(bar[level], widest / times);
  }
}

double judged_scale(const ForceField::Prediction& judged, const Vec3& force) {
  return std::hypot(judged.deviation, (judged.force - force).norm());
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

}  // namespace forefeel
