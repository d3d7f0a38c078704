#pragma once
// Means with confidence intervals over traces and seeds, paired differences, and rankings made from them.
//
// y_gi is the value of replicate i (a seed) in group g (a trace). Every group weighs the same, whatever its
// size:
//   m_g = mean_i y_gi,   m = mean_g m_g
// Two intervals for m, because neither is enough alone:
//   Student    m +- t_{G-1} s_m / sqrt(G), s_m the deviation of the m_g over G groups (of the replicates where
//              G = 1). It says what other traces of this kind would give; honest, but wide with few traces.
//   bootstrap  two-stage percentile: groups are drawn with replacement, then replicates within each (Davison,
//              Hinkley, Bootstrap Methods and their Application, 1997, 3.8). It assumes no distribution, and is
//              too narrow below about 5 groups.
//
// For shares, values in [0, 1], Student's interval is made on the logit scale and taken back, so that it
// stays between 0 and 1:
//   logit m +- t_{G-1} (s_m / sqrt(G)) / (m (1 - m)),   logit m = ln(m / (1 - m))
// (the logit interval of Brown, Cai, DasGupta, Interval Estimation for a Binomial Proportion, Statistical
// Science 16, 2001, with the variance between groups as in svyciprop, method xlogit, Lumley, Complex Surveys,
// 2010). The bootstrap of shares stays there by itself. Differences of shares may be negative and are not
// treated as shares.
//
// A comparison pairs the same trace, seed and remaining settings: y = y_a - y_b.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace forefeel {

struct ConfidenceInterval {
  double mean, low, high;  // low and high NaN where one observation gives no spread
  bool excludes_zero() const { return low > 0 || high < 0; }
};

// Groups may be of different size; empty groups and NaN values are left out.
using GroupedValues = std::vector<std::vector<double>>;

struct BootstrapOptions {
  double confidence = 0.95;
  std::size_t resamples = 4000;
  std::uint64_t seed = 0;  // same seed, same interval
  bool shares = false;     // the values are shares; differences of them, in rankings, are not
};

double student_quantile(double probability, double freedom);
ConfidenceInterval student_interval(const GroupedValues& values, double confidence = 0.95);
// Of values in [0, 1]; no width where all of them are 0 or all are 1.
ConfidenceInterval share_interval(const GroupedValues& values, double confidence = 0.95);
ConfidenceInterval bootstrap_interval(const GroupedValues& values, const BootstrapOptions& options = {});

struct Comparison {
  ConfidenceInterval student, bootstrap;
  std::size_t pairs = 0, groups = 0;
  std::size_t won = 0, lost = 0;  // pairs where y > 0, y < 0
  // +1 or -1 where both intervals exclude zero on that side, else 0.
  int verdict() const;
};
// Of the values themselves: `a - b` already taken, one value a pair.
Comparison compare(const GroupedValues& differences, const BootstrapOptions& options = {});

// The value of contender `level` in block `block`, which belongs to trace `group`. A block is what all
// contenders share: trace, seed and every other setting.
struct Observation {
  std::size_t level = 0, block = 0, group = 0;
  double value = 0;
};

struct Ranked {
  std::size_t level = 0;
  Comparison value;    // of the level's own mean; verdict means nothing here
  Comparison to_best;  // level - best, paired; zero for the best itself
  bool tied = false;   // its difference to the best is not shown
};

struct Ranking {
  std::vector<Ranked> ranked;  // best first
  std::size_t blocks = 0;      // used
  std::size_t dropped = 0;     // blocks where a level is missing or NaN: never used, for no level
};

Ranking rank(std::span<const Observation> observations, std::size_t levels, bool larger_is_better,
             const BootstrapOptions& options = {});
// a - b over the blocks that hold both.
Comparison compare_levels(std::span<const Observation> observations, std::size_t a, std::size_t b,
                          const BootstrapOptions& options = {});

}  // namespace forefeel
