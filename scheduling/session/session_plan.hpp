#pragma once
// All that is fixed before the first frame of a session, checked and made once.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "scheduling/judge/session_judge.hpp"
#include "scheduling/plan/planner.hpp"
#include "scheduling/render/render_loop.hpp"
#include "scheduling/session/arrivals.hpp"
#include "scheduling/session/session_input.hpp"
#include "scheduling/session/session_options.hpp"

namespace forefeel {

// Made by make_plan() and not changed then. Copies share the device, which begins its motion anew when asked
// for an earlier time; so they run one after the other. Only options.stop may be set later.
struct SessionPlan {
  SessionInput input;
  SessionOptions options;  // clock.seconds is what clock.length makes of it
  std::shared_ptr<Device> device;
  std::size_t frames = 0;
  std::vector<Vec3> motion = {};       // by frame, for a policy that knows it [m]; else empty
  std::vector<Arrival> arrivals = {};  // by growing time
  bool given_arrivals = false;         // states become known at these times, and nothing is dispatched
  bool replay_of_arrivals = false;     // the run that is repeated was such a run
  RenderOptions render = {};           // the force limit is the device's where that is lower
  ModelRecipe model = {};
  int batch = 1;  // states of one job
};

// Makes the plan: reads the files of motion and arrivals, once. Throws InputError for what cannot be run:
// unknown names, a bad trace, no workers … Solves and writes nothing.
SessionPlan make_plan(SessionInput input, SessionOptions options);

// The same session with these states known at the start besides those of the plan.
SessionPlan with_known(SessionPlan plan, std::vector<State> known);
// The same session, which appends the states that it solves to this file.
SessionPlan with_state_file(SessionPlan plan, std::filesystem::path file);

// The same session under another policy.
SessionPlan with_policy(SessionPlan plan, const PolicySpec& policy);

// Whether several schedules are tried before the session itself is run: policy clairvoyant under the virtual
// clock.
bool is_rehearsed(const SessionPlan& plan);

// What simulated workers charge; measures the body where the cost is RecordedCost.
std::unique_ptr<CostModel> cost_model(const SessionPlan& plan, ReferenceService& references);

// What the plan's parts take.
PlannerSetup planner_setup(const SessionPlan& plan);
JudgeSetup judge_setup(const SessionPlan& plan);

}  // namespace forefeel
