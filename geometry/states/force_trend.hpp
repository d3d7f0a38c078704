#pragma once
// Do the forces of given states push back, as those of an elastic body on a tip do? Let
//   f = f_0 - K x
// be the least-squares fit to all of them, K taken along the directions in which the positions spread. Its symmetric
// part is positive definite for a clamped body. If it is not, one of the 48 ways to exchange the columns of the force
// and to turn their signs may make it so: the force on the tissue in place of that on the tip, axes of a sensor that is
// mounted turned. A force at rest, where there is none, is the offset of a sensor.

#include <span>
#include <string>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// One line each, with its remedy; none: nothing was found, or the forces follow no such fit (less than half of their
// variance). O(n).
std::vector<std::string> contrary_forces(std::span<const State> states);

}  // namespace forefeel
