#pragma once
// What run_session is put together from; not for users.

#include "scheduling/judge/run_analysis.hpp"
#include "scheduling/session/session_plan.hpp"

namespace forefeel {

class CostModel;

void run_virtual(const SessionPlan& plan, const CostModel& cost, ReferenceService& references,
                 RunAnalysis& analysis, SessionResult& result, const ShowProgress& show);
void run_real(const SessionPlan& plan, ReferenceService& references, SessionResult& result,
              const ShowProgress& show);

// cost: of simulated workers; null under the real clock.
Planner::Hooks hooks_of(const SessionPlan& plan, const CostModel* cost, StateWriter* writer);
std::unique_ptr<StateWriter> open_state_file(const SessionInput& input);      // null: none
void take_loop(RenderLoop& loop, std::size_t frames, SessionResult& result);  // its log and counters

}  // namespace forefeel
