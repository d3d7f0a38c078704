#pragma once
// The arguments of `forefeel session`, and the session plan made from them. Options that are not given come from the
// scene.

#include <memory>
#include <optional>
#include <string>

#include "apps/console/console.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/mpi_run.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_session.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/rank_pool.hpp"

namespace forefeel {

// States known at the start. The file is read only, unless `extend`.
struct KnownStatesArguments {
  std::string file;
  bool extend = false;   // new states are appended to the file
  bool foreign = false;  // states of another body: they are rendered, and nothing is solved
};

struct MotionArguments {
  std::optional<std::string> device, clock, predictor, replay;
  std::optional<double> seconds;  // [s]
};

// What is solved, by which workers and when.
struct SolvingArguments {
  std::optional<std::string> policy, workers_kind, cost, arrivals;
  std::optional<int> workers;
  std::optional<double> latency;  // [s]
};

struct SessionArguments {
  std::string scene, output;
  KnownStatesArguments states;
  MotionArguments motion;
  SolvingArguments solving;
  std::optional<std::string> switching, select;
  std::optional<double> shape_rate;  // [Hz]
  FigureArguments figures;
  MpiArguments mpi;
};

// The options of the scene, with those of the command line in their place.
SessionOptions session_options_of(const Globals& globals, const SessionArguments& given, const Scene& scene);

// Makes and checks the plan. An InputError names the place that gave the value. ranks: null unless ranks of an MPI run
// are the workers. displacements: states must hold them, whatever the scene says. field: of a body that may be touched
// anywhere.
SessionPlan plan_of(const Globals& globals, const SessionArguments& given, const Scene& scene,
                    const std::shared_ptr<RankPool>& ranks, bool displacements,
                    std::optional<SessionField>& field);

// A replay takes its motion and its arrivals from the run. Options of motion and planning are ignored; a
// warning says which.
void warn_of_replay(const Globals& globals, const Scene& scene, const SessionArguments& given);

}  // namespace forefeel
