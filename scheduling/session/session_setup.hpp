#pragma once
// The parts of a session and their settings, as its plan gives them. run_once() divides the plan once by who needs
// what; what runs below gets its own part and knows no plan.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/states/state_header.hpp"
#include "scheduling/common/factory_context.hpp"
#include "scheduling/common/session_result.hpp"
#include "scheduling/judge/session_judge.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/render/contact.hpp"
#include "scheduling/render/input_format.hpp"
#include "scheduling/render/model_keeper.hpp"
#include "scheduling/session/planner.hpp"
#include "scheduling/session/session_plan.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"

namespace forefeel {

// Number of frames that a real loop may record beyond those of the session, for the ramp of the force at the end.
inline constexpr std::size_t spare_frames = 256;

// Where the tip is, and for how long.
struct RunMotion {
  std::shared_ptr<Device> device;
  std::string name;  // of the device, as the user wrote it
  ClockOptions clock = {};
  StopOptions stop = {};
  std::size_t frames = 0;
  std::span<const Vec3> known = {};  // by frame [m], for policies that read it; else empty
};

// Who solves.
struct RunSolving {
  WorkerOptions options = {};
  RealWorkersContext context = {};         // of workers made from the options
  std::shared_ptr<RealWorkers> real = {};  // given as objects; null: made from the options
  std::shared_ptr<VirtualWorkers> simulated = {};
  std::shared_ptr<const CostModel> cost = {};  // of simulated ones; null under the real clock
  bool rest_first = true;
  std::span<const Arrival> arrivals = {};  // states that become known by themselves, by increasing time
  bool dispatches = true;                  // false: no others are solved
};

struct RunRendering {
  RenderOptions options = {};
  ModelRecipe model = {};
  std::shared_ptr<SurfaceModels> surface = {};  // of a body that may be touched anywhere; null: one place

  std::unique_ptr<ModelMaker> maker(const StateSpace& known, LoopLink& link) const;
  std::unique_ptr<Contact> contact(LoopLink& link) const;
};

// The files that are written while the run goes on; none where the path is not set.
struct RunRecord {
  std::optional<std::filesystem::path> states = {}, inputs = {};
  StateFileHeader states_header = {};
  InputHeader inputs_header = {};
};

// What the notes after the run compare it with.
struct RunBounds {
  StateSpaceOptions space = {};
  double visit_cell = 0;  // [m]
};

struct RunSetup {
  RunMotion motion;
  PlannerSetup planning;
  RunSolving solving;
  RunRendering rendering;
  JudgeSetup judging;
  RunRecord record;
  RunBounds bounds;
  RunReport report = {};                // what is known of it before the first frame
  std::vector<std::string> notes = {};  // the same, in words
};

// The references measure the cost of solves where the plan wants that. The plan must outlive the setup.
RunSetup divide(const SessionPlan& plan, ReferenceService& references);

// Whether the session is simulated in advance (run_session.cpp): policy clairvoyant under the virtual clock.
bool is_rehearsed(const SessionPlan& plan);

// The parts of a session as objects: those given, otherwise those that the options name.
FactoryContext factory_context(const SessionInput& input, std::uint64_t seed);
std::shared_ptr<Policy> policy_of(const SessionInput& input, const SessionOptions& options);
std::shared_ptr<Predictor> predictor_of(const SessionInput& input, const SessionOptions& options);

// The costs at a coarse grid of positions, whose median is the planner's first estimate of a solve [s].
// InputError for a cost that is negative or NaN.
std::vector<double> coarse_costs(const CostModel& cost, const Box& box);

StateFileHeader states_header(const TouchedBody& touched);

// The settings for the planner and the judge alone.
PlannerSetup planner_setup(const SessionPlan& plan);
JudgeSetup judge_setup(const SessionPlan& plan);

}  // namespace forefeel
