#pragma once
// Everything that is fixed before the first frame of a session. It is checked and made once.
//
// All functions work in the caller's thread and may be called from several threads at once for different plans. A plan
// is an immutable value. Its copies share the device, the other parts given as objects, and the references. Plans that
// share parts must not run at the same time, because parts have state. Registered parts other than the device are made
// anew for each run: run_session() calls their factories again.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scheduling/session/planned_session.hpp"

namespace forefeel {

// Makes the plan and reads the files of motion and arrivals, once. Throws InputError for anything that cannot
// run: unknown names, a bad trace, no workers, a factory that throws … Apart from that it throws only std::bad_alloc
// and what parts given as objects throw. Solves and writes nothing.
SessionPlan make_plan(SessionInput input, SessionOptions options);

// The same session, with these states known at the start in addition to those of the plan.
SessionPlan with_known(SessionPlan plan, std::vector<State> known);
// The same session, rendering only these states of another body (SessionInput::foreign). InputError if states arrive at
// given times: they would be solved for the touched body.
SessionPlan with_foreign(SessionPlan plan, std::vector<State> known);
// The same session, appending its solved states to this file.
SessionPlan with_state_file(SessionPlan plan, std::filesystem::path file);

// The same session, recording its inputs in this file (render/input_log.hpp), unless options.record is false.
// program: name and version of the recording program.
SessionPlan with_inputs_file(SessionPlan plan, std::filesystem::path file, std::string program);

// The same session under another policy.
SessionPlan with_policy(SessionPlan plan, const PolicySpec& policy);

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
