#pragma once
// Rest jets of bodies, and the difference of a fine body's and a coarse body's (solver/body/fine_jet.hpp). One factor
// of the fine body at rest and nine solves.

#include <memory>
#include <string>

#include "geometry/common/error.hpp"
#include "solver/body/body.hpp"
#include "solver/body/fine_jet.hpp"

namespace forefeel {

// K and the jet of order 4 at rest. InputError at `where` if the body has no stable equilibrium at rest.
RestJet rest_jet(const Body& body, const InputPlace& where);

// What the fine body is: element, tetrahedra, and a hash of its identity.
std::string fine_body_in_words(const Body& fine);

}  // namespace forefeel
