#pragma once
// Runs a planned session once, without rehearsals, and evaluates it.

#include "scheduling/session/session.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

// The reference service given in the input; otherwise a new one.
std::shared_ptr<ReferenceService> references_of(const SessionInput& input, const WorkerOptions& workers);

// Whether the state at rest must be known from the start but is not among the known states. If so, run_once() appends
// it to them.
bool adds_rest(const SessionInput& input, const SessionOptions& options);

struct ShapedRun;  // shaped_run.hpp

// shapes: null without them.
SessionResult run_once(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes = nullptr);

}  // namespace forefeel
