#pragma once
// Slices through the box that show where a session knew states (a gnuplot script, see plot.hpp).

#include <array>
#include <utility>
#include <vector>

#include "apps/picture/figure.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

// Input of the slices: the time at which each state became known [s], ascending, and the motion.
struct SliceInput {
  std::array<std::vector<double>, 3> path;  // x, y, z of each frame [m]
  std::vector<double> t;                    // [s]
  std::vector<std::pair<double, State>> states;
};

// Labels, states and path in the plane of most motion, after an eighth, half and all of the session.
Figure slice_figure(const SliceInput& slice, const StateSpaceOptions& space);

}  // namespace forefeel
