#pragma once
// How long a session knew the force within a tolerance (geometry/common/tolerance.hpp), judged by its error bars, and
// how often that was true. A frame counts as known if the bar of 95 % around its rendered force F is at most
// limit(F); that is true if |F - f| <= limit(f), f the force of a tight solve.

#include <cstddef>

#include "geometry/common/tolerance.hpp"
#include "scheduling/log/session_result.hpp"

namespace forefeel {

struct ToleranceShare {
  std::size_t frames = 0, frames_known = 0;
  std::size_t samples = 0, known = 0, known_true = 0, within = 0;  // within: of all samples
};

ToleranceShare tolerance_share(const SessionResult& result, const Tolerance& tolerance);

}  // namespace forefeel
