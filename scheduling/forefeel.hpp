#pragma once
// Forefeel as a library: all headers that a user's program needs. SI units throughout.
//
//   #include <forefeel/forefeel.hpp>      // installed; find_package(forefeel), target forefeel::forefeel
//
// Programs to start from are in apps/examples (installed: share/forefeel/examples).
// Not included here, but installed beside it: geometry/coverage/estimate_spacing.hpp (the spacing of given
// states), geometry/common/csv_table.hpp (tables), scheduling/record/run_files.hpp (the files of a run),
// scheduling/study/study.hpp (many sessions compared), forefeel/command.hpp (the command as a function).

// What is known, and where?
#include "geometry/common/error.hpp"
#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/states/state.hpp"
#include "geometry/states/state_file.hpp"
// What is the force at x?
#include "solver/body/body.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"
// What is the force now, given the known states?
#include "approx/methods/evaluate.hpp"
#include "approx/model/model.hpp"
#include "approx/model/updater.hpp"
#include "approx/switch/force_switch.hpp"
// Which state is solved next, by which worker, and when?
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/motion/trace.hpp"
#include "scheduling/motion/trace_check.hpp"
#include "scheduling/motion/trace_file.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
