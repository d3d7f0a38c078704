#pragma once
// The part of a summary that is about touches of a body that may be touched anywhere.

#include <cstddef>

#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct TouchTask;

// Touches of a body that may be touched anywhere. Shares: `time` of the frames, `slipping` of those in touch.
struct TouchNumbers {
  std::size_t count = 0, jets = 0;  // that began; jets at rest that were made at the hand's place
  double time = unknown, slipping = unknown;
  double slid = 0, lost = 0, stored = 0;  // way of the site [m]; energy lost, the most that was stored [J]
  double cone = unknown;                  // |(|g| / f . n) - mu| / mu while sliding on a facet, the largest
  double angle_p50 = unknown, angle_p95 = unknown;  // of the force to the normal [rad]
};

// Jets at rest that were made at the hand's place; they are counted apart from states.
bool is_jet_at_rest(const DispatchRecord& dispatch);
std::size_t jets_at_rest(const SessionResult& result);  // solved ones

TouchNumbers touches_of(const SessionResult& result, const TouchTask& task);

}  // namespace forefeel
