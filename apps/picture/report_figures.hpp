#pragma once
// The pictures of a run's report, as gnuplot scripts (see plot.hpp).

#include <span>
#include <string>
#include <vector>

#include "scheduling/log/session_result.hpp"

namespace forefeel {

extern const char* const figure_style;  // gnuplot style of axes, tics and grid

struct Figure {
  std::string name;  // prefix of its ids
  std::string caption;
  int width = 960, height = 400;
  std::string script;
};

// Over one time axis: force, labels, number of known states, error and its parts.
Figure time_figure(std::span<const FrameRecord> frames);
// Force over the first 0.6 s.
Figure start_figure(std::span<const FrameRecord> frames);
// Cost and wake-up lateness of the loop; only with a real clock.
bool has_deadlines(std::span<const FrameRecord> frames);
Figure deadline_figure(std::span<const FrameRecord> frames);

}  // namespace forefeel
