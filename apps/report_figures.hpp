#pragma once
// The pictures of a run's report, as gnuplot scripts (see plot.hpp).

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/run_table.hpp"
#include "geometry/state_space.hpp"

namespace forefeel {

struct Run {
  RunTable frames, dispatch, switches;
  nlohmann::ordered_json summary;
  std::vector<std::pair<double, State>>
      states;  // when each became known [s], 0 for those of the start; growing
};

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
Figure time_figure(const Run& run);
// Force over the first 0.6 s.
Figure start_figure(const Run& run);
// Labels in the plane of most motion, states and path, at an eighth, at half and at the end of the session.
Figure slice_figure(const SliceInput& slice, const StateSpaceOptions& space);
// Cost and wake-up lateness of the loop; only with a real clock.
bool has_deadlines(const Run& run);
Figure deadline_figure(const Run& run);

}  // namespace forefeel
