#pragma once
// Decides from held-out forces (offline_bar.hpp) where the error is within a tolerance, and which spacing keeps it
// within the tolerance.
//   known within    e_95(x) <= limit(f~(x)): the 95 % bar is no larger than the tolerance
//   spacing         the largest h [m] for which |f~ - f| <= limit(f) holds for at least 95 % of the held-out forces
//                   that would be safe at h, pi <= safe_spread h (geometry/coverage/coverage.hpp); at least 20 of them
// f [N]: held-out force, f~ [N]: prediction from the other states, limit [N]: geometry/common/tolerance.hpp. Safe:
// densely known (says nothing of stability).

#include <cstddef>
#include <span>

#include "approx/error/offline_bar.hpp"
#include "geometry/common/tolerance.hpp"

namespace forefeel {

// Number of held-out forces, of those called known within the tolerance, and of those that truly were within it.
struct KnownWithin {
  std::size_t samples = 0, called = 0, true_ones = 0;
};
KnownWithin known_within(std::span<const BarSample> samples, const Tolerance& tolerance);

struct SpacingAdvice {
  double spacing = unknown;          // h [m]; NaN: no spacing suffices
  std::size_t safe = 0, within = 0;  // held-out forces that are safe at h; of these within the tolerance
  std::size_t wider = 0, wider_within = 0;  // safe only at larger spacings up to 1.5 h; of these within
  bool all = false;  // all held-out forces are safe at h: a larger spacing might do as well
};
SpacingAdvice advise_spacing(std::span<const BarSample> samples, const Tolerance& tolerance,
                             double safe_spread);

}  // namespace forefeel
