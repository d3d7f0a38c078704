#pragma once
// The first guess of a session: the stiffness of the body itself at its contact at rest,
//   K = H_cc - H_cf H_ff^{-1} H_fc [N/m]
// H: second derivatives of the energy at rest, f: the free nodes, c: the contact (factorisation.hpp). K takes one
// factorisation before the session: milliseconds for some thousand elements. It is exact at rest for any shape, clamp
// and material. Away from rest, nonlinear bodies depart from -K x. The error bar rendered with the guess is that of a
// model of one known state (approx/error/error_scale.hpp). There is no guess if the factorisation would take more than
// most_guess_work.

#include <memory>
#include <string>

#include "solver/body/body.hpp"

namespace forefeel {

struct FirstGuess {
  Mat3 stiffness = Mat3::Zero();  // K, or zero where it is left out [N/m]
  // How many times softer the body is than the half-space of disc_stiffness() (body/contact_stiffness.hpp): the largest
  // ratio over all directions; unknown without K or without the disc's stiffness.
  double softness = 0;
  std::string left_out = {};  // why; empty where it is rendered
};

inline constexpr std::int64_t most_guess_nodes = 10'000;  // of the elements
inline constexpr double most_guess_work = 2e9;            // multiplications of the factorisation

FirstGuess first_guess(const std::shared_ptr<const Body>& body);

}  // namespace forefeel
