#pragma once
// Share of the frames of a session whose force was known within a tolerance (geometry/common/tolerance.hpp) according
// to its error bars, and how often this was true. A frame counts as known if the half-width of the bar of 95 % around
// its rendered force F [N] is at most limit(F). This was true if |F - f| <= limit(f), with f [N] the force of a tight
// solve. For a viscous body, F and f are the elastic forces.

#include <cstddef>

#include "geometry/common/tolerance.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct ToleranceShare {
  std::size_t frames = 0, frames_known = 0;
  std::size_t samples = 0, known = 0, known_true = 0, within = 0;  // frames with f; within: of all samples
};

ToleranceShare tolerance_share(const SessionResult& result, const Tolerance& tolerance);

}  // namespace forefeel
