#pragma once
// A session with shapes of the body beside its forces (shape/shape_log.hpp):
//   virtual clock   a stage that follows the run; the frames are the same with and without it
//   real clock      a thread of its own, which the planner feeds; the 1 kHz loop has no part in it
//
//   plan.input.touched.displacements = true;              // before make_plan(): states hold them
//   ShapedRun shapes{.log = std::make_shared<ShapeLog>(body, ShapeOptions{.rate = 30})};
//   const SessionResult result = run_session(plan, hooks, &shapes);

#include "scheduling/session/session.hpp"
#include "scheduling/session/shaped_run.hpp"

namespace forefeel {

// shapes: null for a session without. InputError where states would not hold displacements. If shapes fail
// during the run, result.failures says so in one line, and the run goes on without them.
SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes);

}  // namespace forefeel
