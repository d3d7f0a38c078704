#pragma once
// How the models of a session are made from its states.

#include "approx/model/model_options.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

enum class SessionMethod {
  rbf,        // radial basis functions around the HIP
  trilinear,  // in the lattice cell around the HIP
  tricubic    // the same
};

struct SessionModelOptions {
  // Model of method rbf; also the default of scenes without [model]. It uses the stiffness of states, which every
  // solved state has.
  ModelOptions fit = {.kernel = Kernel::quintic, .data = Data::force_and_stiffness, .neighbours = 25};
  SessionMethod method = SessionMethod::rbf;
  double update_travel = 0.25;  // HIP travel that triggers an update, in spacings
  // While no state is known, render the stiffness of the body at rest (solver/equilibrium/first_guess.hpp): one
  // factorisation before the session. The first solved state replaces it, faded in like any new model. Ignored if
  // states come from files or are known at the start. If the body is so large that the factorisation takes long, there
  // is no guess: a note says so, and nothing is rendered until a state is known.
  bool first_guess = true;
};

// Throws InputError with the key of an invalid value.
void check(const SessionModelOptions& options);

// The same options, completed by the plan of the session.
struct ModelRecipe {
  ModelOptions fit = {};  // neighbours capped at the number of states (for_states)
  SessionMethod method = SessionMethod::rbf;
  double update_travel = 0.25;  // [spacings]
  Mat3 guess = Mat3::Zero();    // stiffness while no state is known [N/m]; zero: none
};

}  // namespace forefeel
