#pragma once
// Forefeel as a library: everything that a program of its own needs. SI units throughout.
//
//   #include <forefeel/forefeel.hpp>      // installed; find_package(forefeel), target forefeel::forefeel
//
// Programs to start from are in apps/examples (installed: share/forefeel/examples).

// Where is what known?
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
// What is the force now, from what is known?
#include "approx/model/model.hpp"
#include "approx/select/updater.hpp"
#include "approx/switch/force_switch.hpp"
// What is solved next, by whom, when?
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/record/summary.hpp"
#include "scheduling/session/session.hpp"
#include "scheduling/workers/cost.hpp"
#include "scheduling/workers/generator.hpp"
