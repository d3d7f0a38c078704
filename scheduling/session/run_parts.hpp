#pragma once
// Functions shared by the runs of both clocks.

#include <memory>

#include "scheduling/session/session_plan.hpp"

namespace forefeel {

class CostModel;

// The planner's hooks. cost: of simulated workers; null under the real clock. Plan and writer must outlive
// the hooks.
Planner::Hooks hooks_of(const SessionPlan& plan, const CostModel* cost, StateWriter* writer);
// The file that new states are appended to; null: none.
std::unique_ptr<StateWriter> open_state_file(const SessionInput& input);
// Moves the log and the safety counters of a run into its result. `frames`: the number requested.
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);

}  // namespace forefeel
