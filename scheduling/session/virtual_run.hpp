#pragma once
// A session under the virtual clock: a discrete-event simulation of workers, planner and loop. Time is in
// whole nanoseconds. Events have a total order (time, kind, sequence): the workers' results first, then
// arrivals, then planning, then the frame of that instant.

#include "scheduling/session/following_renderer.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

class CostModel;

struct VirtualParts {
  const CostModel& cost;
  ReferenceService& references;  // the values of states
  FramePipeline& pipeline;       // what follows the run
  // A stage of the pipeline. Null where the motion answers the force: the run then renders itself.
  FollowingRenderer* renderer;
};

// Enters all but labels, errors and what judging adds.
void run_virtual(const SessionPlan& plan, const VirtualParts& parts, SessionResult& result,
                 const ShowProgress& show);

}  // namespace forefeel
