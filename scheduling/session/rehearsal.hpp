#pragma once
// Clairvoyant sessions: who knows the motion and what each solve will cost can try a session before it
// counts. It is run under every policy but the placebos, with the motion known and without; the schedule with
// the largest share of first visits within the JND is then run as the session. So it bounds what any policy
// could reach, and takes up to seven times as long.

#include "scheduling/session/session_hooks.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

SessionResult run_rehearsed(SessionPlan plan, const SessionHooks& hooks);

}  // namespace forefeel
