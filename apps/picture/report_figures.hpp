#pragma once
// The pictures of a run's report, as gnuplot scripts (see plot.hpp).

#include <array>
#include <span>
#include <string>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/log/session_result.hpp"

namespace forefeel {

// What the slices show: when each state became known [s], growing, and the motion.
struct SliceInput {
  std::array<std::vector<double>, 3> path;  // by frame [m]
  std::vector<double> t;                    // [s]
  std::vector<std::pair<double, State>> states;
};

struct Figure {
  std::string name;  // of its ids
  std::string caption;
  int width = 960, height = 400;
  std::string script;
};

// Force, label strip, states known, error and its parts over one time axis.
Figure time_figure(std::span<const FrameRecord> frames);
// Force over the first 0.6 s.
Figure start_figure(std::span<const FrameRecord> frames);
// Labels in the plane of most motion, states and path, at an eighth, at half and at the end of the session.
Figure slice_figure(const SliceInput& slice, const StateSpaceOptions& space);
// Cost and wake-up lateness of the loop; only with a real clock.
bool has_deadlines(std::span<const FrameRecord> frames);
Figure deadline_figure(std::span<const FrameRecord> frames);

}  // namespace forefeel
