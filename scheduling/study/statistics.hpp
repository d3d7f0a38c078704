#pragma once
// Means with confidence intervals over traces and seeds, paired differences, and rankings made from them.
//
// y_gi is the value of replicate i (a seed) in group g (a trace). Every group has the same weight, whatever
// its size:
//   m_g = mean_i y_gi,   m = mean_g m_g
// There are two intervals for m, because neither suffices alone:
//   Student    m +- t_{G-1} s_m / sqrt(G), s_m the standard deviation of the m_g over G groups (if G = 1:
//              of the replicates). It holds for other traces of the same kind, but is wide with few traces.
//   bootstrap  two-stage percentile: draws groups with replacement, then replicates within each (Davison,
//              Hinkley, Bootstrap Methods and their Application, 1997, 3.8). It assumes no distribution, but
//              is too narrow below about 5 groups.
//
// For shares, values in [0, 1], Student's interval is computed on the logit scale and transformed back, so it
// stays between 0 and 1:
//   logit m +- t_{G-1} (s_m / sqrt(G)) / (m (1 - m)),   logit m = ln(m / (1 - m))
// (the logit interval of Brown, Cai, DasGupta, Interval Estimation for a Binomial Proportion, Statistical
// Science 16, 2001, with the variance between groups as in svyciprop, method xlogit, Lumley, Complex Surveys,
// 2010). The bootstrap interval of shares needs no transformation. Differences of shares may be negative;
// they are not treated as shares.
//
// Several levels against the best: the p values of Student's paired test are adjusted by Holm (1979), so that
// the chance of any false difference stays below 5 %. Mean ranks of levels differ (Nemenyi; Demsar 2006) by at least
//   q_k sqrt(k (k + 1) / (6 G))   for k levels that compete, q_k: Studentised range over sqrt 2
//
// A comparison pairs the same trace, seed and remaining settings: y = y_a - y_b.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace forefeel {

struct ConfidenceInterval {
  double mean, low, high;  // low and high are NaN for a single observation
  bool excludes_zero() const { return low > 0 || high < 0; }
};

// Groups may differ in size; empty groups and NaN values are left out.
using GroupedValues = std::vector<std::vector<double>>;

struct BootstrapOptions {
  double confidence = 0.95;
  std::size_t resamples = 4000;
  std::uint64_t seed = 0;  // same seed, same interval
  bool shares = false;     // the values are shares; their differences in rankings are not
};

double student_quantile(double probability, double freedom);
ConfidenceInterval student_interval(const GroupedValues& values, double confidence = 0.95);
// For values in [0, 1]; the interval has no width if all are 0 or all are 1.
ConfidenceInterval share_interval(const GroupedValues& values, double confidence = 0.95);
ConfidenceInterval bootstrap_interval(const GroupedValues& values, const BootstrapOptions& options = {});

struct Comparison {
  ConfidenceInterval student, bootstrap;
  std::size_t pairs = 0, groups = 0;
  std::size_t won = 0, lost = 0;  // pairs where y > 0, y < 0
  // Two-sided, of Student's test that the mean is 0; NaN without an interval of 95 %.
  double p_value() const;
  // +1 or -1 if both intervals lie on that side of zero, else 0.
  int verdict() const;
};
// differences: a - b, one value per pair.
Comparison compare(const GroupedValues& differences, const BootstrapOptions& options = {});

// The value of contender `level` in block `block` of trace `group`. A block holds the values of all
// contenders for one trace, one seed and the same other settings.
struct Observation {
  std::size_t level = 0, block = 0, group = 0;
  double value = 0;
};

struct Ranked {
  std::size_t level = 0;
  Comparison value;      // of the level's own mean; its verdict is meaningless
  Comparison to_best;    // level - best, paired; zero for the best itself
  bool tied = false;     // its difference to the best is not significant
  double holm = 1;       // p value against the best, adjusted over the levels that compete; NaN for others
  double mean_rank = 0;  // over the groups, 1: best; NaN for those that do not compete
};
// Adjusted p values, in the same order: max over the smaller ones of (number of them and those above) p. NaN stays.
std::vector<double> holm(std::span<const double> p_values);
// Nemenyi's critical difference of mean ranks, 5 %; NaN beyond 20 levels or below 2, or without groups.
double critical_difference(std::size_t levels, std::size_t groups);
inline constexpr double significant = 0.05;

struct LevelRanking {
  std::vector<Ranked> ranked;  // best first; then those that do not compete
  std::size_t blocks = 0;      // used
  std::size_t dropped = 0;     // blocks where a level is missing or NaN: not used for any level
};

// beside: levels that do not compete. They stand last and are not the best.
LevelRanking rank(std::span<const Observation> observations, std::size_t levels, bool larger_is_better,
                  const BootstrapOptions& options = {}, std::span<const std::size_t> beside = {});
// Sets `holm` and `tied` from the comparisons with the best.
void adjust(LevelRanking& ranking, std::span<const std::size_t> beside = {});
// Compares a - b over the blocks that hold both.
Comparison compare_levels(std::span<const Observation> observations, std::size_t a, std::size_t b,
                          const BootstrapOptions& options = {});

// Number of motions (groups) with which Student's 95 % interval of this difference excludes zero with a probability of
// 80 % (power), if mean and standard deviation stay the same. nullopt if there is only one group, if the mean is zero,
// or if a thousand motions are not enough.
// size: another mean to show, as 0.02 for 2 points.
std::optional<std::size_t> motions_needed(const Comparison& difference, std::optional<double> size = {});

}  // namespace forefeel
