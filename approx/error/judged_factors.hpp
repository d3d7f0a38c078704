#pragma once
// Factors of the bars that a process judges: g, by which its deviation s is widened, and q_p, quantiles of |e| / (g s).
// offline_bar.hpp has the equations.

#include <array>
#include <vector>

#include "approx/error/conformal_factors.hpp"

namespace forefeel {

// Sums over samples: of 1, of the share of s^2 in the variance of the comparison, and of that share times y^2.
struct Misfit {
  double samples = 0, share = 0, missed = 0;
  void add(const Misfit& other) { samples += other.samples, share += other.share, missed += other.missed; }
};

// g, if a sample counts as `each` groups. shrinkage: r.
double trust_of(const Misfit& of, double each, double shrinkage = 1);

// q_p of each level from the scores y_i of samples that count as `each` groups. share: sum of w_i.
std::array<double, bar_levels.size()> judged_factors(std::vector<double> scores, double each, double share);

}  // namespace forefeel
