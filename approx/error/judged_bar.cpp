#include <algorithm>
#include <cmath>

#include "approx/error/error_bar.hpp"
#include "geometry/common/quantiles.hpp"

// Bars of measured forces. A Gaussian process of them judges them (measured/force_field.hpp). It knows the noise sigma
// of their forces and how far the force may be from its own:
//   s(x)^2 = deviation(x)^2 + |f~ - process|^2,   e_p(x) = q_p sqrt(v(x)) + m_p S E
// S E: least error across the states. The bar is that of the force itself, without the noise of a measurement.

namespace forefeel {
namespace {

constexpr double prior_groups = 6;  // nu: groups that the process's own deviation counts as
constexpr std::size_t level_of_95 = 1, local_samples = 30;
constexpr BarFactors steeper{2, across_of_95, 4};  // m_p

double square(double x) {
  return x * x;
}

// Sums over samples: of 1, of the share of s^2 in the variance of the comparison, and of that share times y^2.
struct Misfit {
  double samples = 0, share = 0, missed = 0;
  void add(const Misfit& other) { samples += other.samples, share += other.share, missed += other.missed; }
};

// Quantiles u of |e| over its root mean square, e of three normal components whose variance is known from n degrees of
// freedom: u^2 has the distribution F(3, n), so u has the density C u^2 (1 + 3 u^2 / n)^(-(n + 3) / 2).
BarFactors quantiles_of_norm(double n) {
  constexpr double step = 1e-3, farthest = 100;
  const double log_c = std::log(2.0) + 1.5 * std::log(3 / n) + std::lgamma(0.5 * (n + 3)) - std::lgamma(1.5) -
                       std::lgamma(0.5 * n);
  BarFactors found;
  double share = 0, u = 0;
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    for (; share < bar_levels[level] && u < farthest; u += step) {
      const double middle = u + 0.5 * step;
      share +=
          step * std::exp(log_c + 2 * std::log(middle) - 0.5 * (n + 3) * std::log1p(3 * middle * middle / n));
    }
    found[level] = u;
  }
  return found;
}

// g, by which s is widened: its own deviation counts as nu groups, of n held out in turn, and K = n mean(w):
//   g^2 = max(1, (nu + n mean(w y^2)) / (nu + K))
// each: groups that a sample counts as.
double trust_of(const Misfit& of, double each) {
  return std::max(1.0, std::sqrt((prior_groups + each * of.missed) / (prior_groups + each * of.share)));
}

// The law was found from n groups, so s is known with few degrees of freedom: the quantiles of sqrt(F(3, n + 1))
// (Student's t of three components; at 95 % 1.61 for many groups, 2.57 for three). Errors may have heavier or lighter
// tails. So q_p is the mean of that quantile, weighted by nu, and of the ceil((n + 1) p) / n quantile of the scores,
// weighted by K; without it for fewer than p / (1 - p) groups. share: sum of w_i.
BarFactors judged_factors(std::vector<double> scores, double each, double share) {
  const double groups = each * static_cast<double>(scores.size());
  BarFactors factors = quantiles_of_norm(groups + 1);
  for (std::size_t level = 0; level < factors.size(); ++level) {
    const double p = bar_levels[level];
    if (level > 0) factors[level] = std::max(factors[level], factors[level - 1]);
    if (groups < p / (1 - p)) continue;
    const double rank = std::min(1.0, std::ceil((groups + 1) * p - 1e-9) / groups);
    const double found = quantile_of(scores, rank, QuantileRule::inverted_cdf);
    factors[level] = (prior_groups * factors[level] + each * share * found) / (prior_groups + each * share);
    if (level > 0) factors[level] = std::max(factors[level], factors[level - 1]);
  }
  return factors;
}

}  // namespace

void widen(BarWidths& widths, double across) {
  for (std::size_t level = 0; level < widths.size(); ++level) widths[level] += steeper[level] * across;
}

// The held-out forces f_i tell whether s is too small. They are measured, and their errors are alike within a group, so
//   y_i^2 = (|f~_i - f_i| - m S E)^2 / (s_i^2 + 3 sigma^2),   w_i = s_i^2 / (s_i^2 + 3 sigma^2)
// w: what a comparison tells of s; nothing where noise is most of it. The samples become those of judged bars: their
// scale is that of a comparison with a measured force, their bar holds the noise.
OfflineBars::OfflineBars(std::vector<BarSample> samples, const JudgedBy& by) : samples_(std::move(samples)) {
  if (samples_.empty()) return;
  judged_ = true;
  Judge& judge = judge_;
  judge.noise = 3 * square(by.noise);
  std::vector<Misfit> of_part;
  Misfit every;
  std::vector<double> excess;
  for (const BarSample& s : samples_) {
    const double own = square(s.scale), seen = own + judge.noise;
    excess.push_back(std::max(0.0, s.error - steeper[level_of_95] * s.across));
    judge.misses.push_back(seen > 0 ? square(excess.back()) / seen : 0);
    const Misfit one{.samples = 1, .share = seen > 0 ? own / seen : 0};
    if (of_part.size() <= s.part) of_part.resize(s.part + 1);
    for (Misfit* sum : {&of_part[s.part], &every})
      sum->add({one.samples, one.share, one.share * judge.misses.back()});
  }
  const double each = std::min(1.0, static_cast<double>(by.groups) / every.samples);  // groups of a sample
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
      for (std::size_t level = 0; level < factors.size(); ++level) s.bar[level] = factors[level] * s.scale;
      widen(s.bar, s.across);
    }
  }
  judge.trust = trust_of(every, each);
  judge.quantiles = judged_factors(std::move(scores), each, every.share);
}

// The law is one for all places, but a force may be rough in some of them (a kink of a stiff wall in a smooth field).
// The process then takes the roughness for noise. Noise is the same everywhere, misfit is not, so with L(x) the mean of
// y^2 over the 30 held-out positions nearest to x, over the mean of all:
//   t(x)^2 = 1 + B (L(x) - 1),   B = max(0, 1 - var_0 / var(L)),   var_0 = 2 / (3 max(1, groups among the 30))
// B shrinks L as far as its differences are those of chance (James and Stein 1961); var_0 is the variance of L if all
// errors were normal with one deviation. c: least t^2 at the held-out positions; there all misses are noise.
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
  judge.calm = judge.mean * (1 + judge.locality * (*std::ranges::min_element(ratios) - 1));
}

double OfflineBars::local(const Vec3& x, std::optional<std::uint32_t> but) const {
  const Judge& judge = judge_;
  if (!(judge.locality > 0)) return 1;
  std::vector<std::pair<double, double>> near;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    if (samples_[i].part != but) near.emplace_back((samples_[i].at - x).squaredNorm(), judge.misses[i]);
  if (near.empty()) return 1;
  const std::size_t count = std::min(local_samples, near.size());
  std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(count - 1));
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) sum += near[k].second;
  return 1 + judge.locality * (sum / (static_cast<double>(count) * judge.mean) - 1);
}

//   v(x) = max(max(1, g^2 t^2) s^2,   mean(y^2) (t^2 (s^2 + 3 sigma^2) - c 3 sigma^2))
// A bar is never narrower than by the process's own deviation: held-out forces lie on the lines and levels of the
// states, where the force is known better than between them.
double OfflineBars::variance(double scale, double trust, double local) const {
  const double own = square(scale);
  const double missed = judge_.mean * local * (own + judge_.noise) - judge_.calm * judge_.noise;
  return std::max(std::max(1.0, square(trust) * local) * own, missed);
}

double OfflineBars::deviation(const BarPlace& place) const {
  return std::sqrt(variance(place.scale, judge_.trust, local(place.x, {})));
}

void keep_together(std::span<BarWidths> bars, std::span<const char> counts, double times) {
  for (std::size_t level = 0; level < bar_levels.size(); ++level) {
    double widest = 0;
    for (std::size_t i = 0; i < bars.size(); ++i)
      if (counts[i] && std::isfinite(bars[i][level])) widest = std::max(widest, bars[i][level]);
    for (BarWidths& bar : bars) bar[level] = std::max(bar[level], widest / times);
  }
}

}  // namespace forefeel
