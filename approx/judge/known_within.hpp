#pragma once
// Where the error is below a tolerance, and the spacing that means the same, from forces left out
// (offline_bar.hpp).
//   known within    e_95(x) <= limit(f~(x)): the bar of 95 % is no larger than the tolerance
//   spacing         the largest h with |f~ - f| <= limit(f) at 95 % of the forces left out that would be safe at h,
//                   pi <= safe_spread h (geometry/coverage/coverage.hpp); at least 20 of them

#include <cstddef>
#include <span>

#include "approx/judge/offline_bar.hpp"
#include "geometry/common/tolerance.hpp"

namespace forefeel {

// Forces left out that were said to be known within the tolerance, and how many of them were.
struct KnownWithin {
  std::size_t samples = 0, called = 0, true_ones = 0;
};
KnownWithin known_within(std::span<const BarSample> samples, const Tolerance& tolerance);

struct SpacingAdvice {
  double spacing = unknown;                 // [m]; NaN: at no spacing
  std::size_t safe = 0, within = 0;         // forces left out that would be safe at it; of these within
  std::size_t wider = 0, wider_within = 0;  // safe only at up to 1.5 times the spacing; of these within
  bool all = false;                         // none of them asks for a smaller one
};
SpacingAdvice advise_spacing(std::span<const BarSample> samples, const Tolerance& tolerance,
                             double safe_spread);

}  // namespace forefeel
