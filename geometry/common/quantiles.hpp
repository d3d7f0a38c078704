#pragma once
// Quantiles of a sample, by one of three rules. Of n values x_1 <= ... <= x_n and a share p in [0, 1]:
//   inverted_cdf   x_k, k = max(1, ceil(p n)): the smallest value x for which at least a share p of the sample
//                  is <= x. Type 1 of Hyndman and Fan, "Sample quantiles in statistical packages" (1996);
//                  `nearest rank` in textbooks
//   nearest        x_{1+k}, k = p (n - 1) rounded, halves up: `nearest` of numpy.quantile, which rounds
//                  halves to even
//   linear         between x_{1+floor(g)} and the next value in the ratio of the fraction of g = p (n - 1).
//                  Type 7 of Hyndman and Fan, the default of numpy and R
// p = 0 is the least value and p = 1 the greatest by each rule. Without values every quantile is NaN.

#include <cstdint>
#include <span>
#include <vector>

namespace forefeel {

enum class QuantileRule : std::uint8_t { inverted_cdf, nearest, linear };

// sorted: ascending, without NaN. O(1).
double quantile(std::span<const double> sorted, double share, QuantileRule rule);

// The same of values in any order; NaN are left out. O(n log n), allocates.
double quantile_of(std::vector<double> values, double share, QuantileRule rule = QuantileRule::nearest);

// The median; of an even number of values, the upper one of the two in the middle. Equal to
// quantile_of(values, 0.5, QuantileRule::nearest), but O(n).
double median(std::vector<double> values);

}  // namespace forefeel
