#pragma once
// What runs under either clock need.

#include <memory>

#include "scheduling/session/session_plan.hpp"

namespace forefeel {

class CostModel;

// cost: of simulated workers; null under the real clock. The plan and the writer must outlive the hooks.
Planner::Hooks hooks_of(const SessionPlan& plan, const CostModel* cost, StateWriter* writer);
// The file that new states are appended to; null: none.
std::unique_ptr<StateWriter> open_state_file(const SessionInput& input);
// Moves the log and the safety counters of a run into its result. `frames`: as many as were asked for.
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);

}  // namespace forefeel
