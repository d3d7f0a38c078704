#pragma once
// The parts of a session and their settings, as its plan gives them.

#include <memory>
#include <vector>

#include "scheduling/common/factory_context.hpp"
#include "scheduling/judge/session_judge.hpp"
#include "scheduling/session/planner.hpp"
#include "scheduling/session/session_plan.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {

FactoryContext factory_context(const SessionPlan& plan);
std::shared_ptr<Policy> policy_of(const SessionPlan& plan);
std::shared_ptr<Predictor> predictor_of(const SessionPlan& plan);

// Whether the session is simulated in advance (rehearsal.hpp): policy clairvoyant under the virtual clock.
bool is_rehearsed(const SessionPlan& plan);

// The cost model of simulated workers. Measures solves of the body if the cost is RecordedCost.
std::unique_ptr<CostModel> cost_model(const SessionPlan& plan, ReferenceService& references);

// The costs at a coarse grid of positions, whose median is the planner's first estimate of a solve [s].
// InputError for a cost that is negative or NaN.
std::vector<double> coarse_costs(const CostModel& cost, const Box& box);

// The plan's settings for the planner and the judge.
PlannerSetup planner_setup(const SessionPlan& plan);
JudgeSetup judge_setup(const SessionPlan& plan);

}  // namespace forefeel
