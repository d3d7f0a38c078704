#pragma once
// Clairvoyant sessions: an upper bound of what a policy can reach. The motion and the cost of every solve are known, so
// the session can be simulated in advance (rehearsed). It is simulated under every policy except the placebos, with and
// without knowledge of the motion. Then the schedule with the largest share of first visits within the JND (just
// noticeable difference) is run. All this takes up to eight times as long as one run.

#include <string>
#include <vector>

#include "scheduling/session/session.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

struct ShapedRun;  // shaped_run.hpp

// The policies that are rehearsed, clairvoyant-greedy first: it is usually the best.
std::vector<std::string> schedules_to_rehearse();

// shapes: of the session itself; null without them.
SessionResult run_rehearsed(SessionPlan plan, const SessionHooks& hooks, ShapedRun* shapes = nullptr);

}  // namespace forefeel
