#pragma once
// Forefeel as a library: all headers that a user's program needs. SI units throughout.
//
//   #include <forefeel/forefeel.hpp>      // installed; find_package(forefeel), target forefeel::forefeel
//
//   const TetMesh mesh = phantom("beam", 240);
//   const Body beam{.mesh = mesh, .clamp = mesh.groups.at("clamp"), .contact = mesh.groups.at("contact")};
//   StateSpace space({.spacing = 0.004, .box = {Vec3::Constant(-0.008), Vec3::Constant(0.008)}});   // [m]
//   generate(beam, space);                                     // solves the states of its lattice
//   const Vec3 x(0.001, 0.003, -0.005);                        // of the tip [m]
//   const Coverage known = space.coverage(x);                  // how well the force at x is known
//   ModelUpdater updater(space, {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25});
//   const Vec3 force = updater.model_at(x).force(x);           // [N]
//
// Programs to start from are in apps/examples (installed: share/forefeel/examples).
// Not included here, but installed beside it (forefeel/…):
//   command.hpp                              the command `forefeel` as a function
//   scene.hpp                                a scene file as input of a session
//   geometry/common/csv_rows.hpp            tables
//   geometry/common/declared.hpp             columns and parts with their meanings, as declared_policies() returns them
//   geometry/coverage/regions.hpp            StateSpace::regions()
//   geometry/index/adaptive_lattice.hpp      StateSpaceOptions::lattice
//   geometry/index/delaunay_index.hpp        StateSpace::delaunay()
//   geometry/index/path_walk.hpp             faster labels along a path
//   approx/error/error_bar.hpp               EvaluatedBars::measured
//   scheduling/placement/placement.hpp       few states at the best places
//   scheduling/record/run_files.hpp          the files of a run
//   scheduling/study/study_ranking.hpp       many sessions compared, from study_run.hpp
//   scheduling/study/study_run.hpp           many sessions run, of study.hpp
//   scheduling/touch/session_surface.hpp     the surface of a body that is touched anywhere
//   scheduling/touch/surface_models.hpp      what a session knows of such a body (TouchedBody::anywhere)
//   scheduling/workers/reference_service.hpp tight solves shared by sessions (SessionInput::references)
//   solver/body/body_digest.hpp              the identity of a body (TouchedBody::identity)
//   solver/equilibrium/mesh_error.hpp        what the mesh itself gets wrong

// What is known, and where?
#include "geometry/common/error.hpp"
#include "geometry/common/types.hpp"
#include "geometry/coverage/coverage.hpp"
#include "geometry/coverage/state_space.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
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
