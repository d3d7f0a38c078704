#pragma once
// What a session knew where, as slices through the box (a gnuplot script, see plot.hpp).

#include <array>
#include <utility>
#include <vector>

#include "apps/picture/report_figures.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

// What the slices show: when each state became known [s], growing, and the motion.
struct SliceInput {
  std::array<std::vector<double>, 3> path;  // by frame [m]
  std::vector<double> t;                    // [s]
  std::vector<std::pair<double, State>> states;
};

// Labels in the plane of most motion, states and path, at an eighth, at half and at the end of the session.
Figure slice_figure(const SliceInput& slice, const StateSpaceOptions& space);

}  // namespace forefeel
