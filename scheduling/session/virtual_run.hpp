#pragma once
// Runs a session under the virtual clock: a discrete-event simulation of workers, planner and loop. Time is
// in whole nanoseconds. Events have a total order (time, kind, sequence): at one instant, results of workers
// come first, then arrivals, planning, and the frame.

#include "scheduling/session/following_renderer.hpp"
#include "scheduling/session/session_setup.hpp"

namespace forefeel {

class InputLog;

struct VirtualParts {
  ReferenceService& references;  // gives the values of states
  FramePipeline& pipeline;       // receives the frames
  // A stage of the pipeline. Null if the motion depends on the force: the run then renders itself.
  FollowingRenderer* renderer;
  InputLog* inputs = nullptr;  // records what came in
};

// Fills the result, except for labels, errors and other values of the judge. If planning fails, the frames
// end there with the ramp at the end, and result.failures says why.
void run_virtual(const RunSetup& setup, const VirtualParts& parts, SessionResult& result,
                 const ShowProgress& show);

}  // namespace forefeel
