#pragma once
// A session with shapes of the body beside its forces (shape/shape_log.hpp):
//   virtual clock   a stage that follows the run; the frames are the same with and without it
//   real clock      a separate thread, to which the planner passes HIP and states; the 1 kHz loop does nothing for it
//
//   plan.input.touched.displacements = true;              // before make_plan(): states hold them
//   ShapedRun shapes{.log = std::make_shared<ShapeLog>(body, ShapeOptions{.rate = 30})};
//   const SessionResult result = run_session(plan, hooks, &shapes);

#include <memory>
#include <vector>

#include "scheduling/session/session.hpp"
#include "scheduling/shape/shape_check.hpp"
#include "scheduling/shape/shape_log.hpp"

namespace forefeel {

struct ShapedRun {
  std::shared_ptr<ShapeLog> log;           // of the touched body
  std::vector<CheckedShape> checked = {};  // filled by the run, by rising record
};

// shapes: null for a session without shapes. InputError if states would not hold displacements. If shapes fail
// during the run, result.failures gets a line, and the run continues without them.
SessionResult run_session(const SessionPlan& plan, const SessionHooks& hooks, ShapedRun* shapes);

}  // namespace forefeel
