#pragma once
// How the models of a session are made from its states.

#include "approx/select/updater.hpp"

namespace forefeel {

enum class SessionMethod {
  rbf,        // radial basis functions around the HIP
  trilinear,  // in the lattice cell around the HIP
  tricubic    // the same
};

struct SessionModelOptions {
  ModelOptions fit = {};  // of method rbf
  SessionMethod method = SessionMethod::rbf;
  double update_travel = 0.25;  // HIP travel that triggers an update, in spacings
  // While nothing is known the hand feels the stiffness that a disc on a half-space of the body's material
  // would have (solver/body/contact_stiffness.hpp): no solve, no state. The first true state replaces it,
  // faded in like any newer model. Not where states come from files, nor where some are known from the start.
  bool first_guess = true;
};

// InputError names the key of a value that cannot be used.
void check(const SessionModelOptions& options);

// The same once a session's plan has decided what the options leave open.
struct ModelRecipe {
  ModelOptions fit = {};  // no more neighbours than there can be states (for_states)
  SessionMethod method = SessionMethod::rbf;
  double update_travel = 0.25;  // [spacings]
  Mat3 guess = Mat3::Zero();    // stiffness felt while nothing is known [N/m]; zero: none
};

}  // namespace forefeel
