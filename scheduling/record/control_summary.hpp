#pragma once
// Summarises the passivity control of a session, and the force error that it added in each frame:
//   e = |F - F'| / max(|F'|, f0)     [1]
// F [N]: force sent, F' [N]: force that the other safety rules alone would have sent at the same positions, f0 [N]: the
// error floor of the session. The ramp at the end is left out.

#include <span>

#include <cstddef>
#include <span>

#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct ControlSummary {
  PassivityReport report;
  double coupled_share = unknown, drained_share = unknown, controlled_share = unknown;  // of the frames
  double added_p50 = unknown, added_p95 = unknown, added_max = unknown;                 // e [1]
};

// sent: F of each frame but those of the ramp at the end.
ControlSummary control_summary(const SafetyReport& safety, std::span<const Vec3> sent, std::size_t frames,
                               double error_floor);
ControlSummary control_summary(const SessionResult& result, double error_floor);

}  // namespace forefeel
