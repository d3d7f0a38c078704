#pragma once
// The result of a study in a sentence, and what its figures rest on, device by device.

#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/study_plan.hpp"
#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// "Best policy: coverage, with 93.1 % of first visits within the JND …: the difference is shown." For the
// axis of policies, or the first axis with two values; nothing if no axis has them. Policies that know the
// motion (clairvoyant …) are bounds: they do not compete. A difference is shown if both 95 % intervals
// exclude zero.
std::optional<std::string> study_verdict(const Study& study, const std::vector<StudyCellResult>& cells);

// One device (a value of the axis `device`, or the device of all cells): means over its cells. Shares in [0,
// 1]; NaN where no cell has a value.
struct StudyDevice {
  std::string device;
  double motion_seconds = 0;                    // of the motion itself [s]; infinite for one without end
  double seconds = 0;                           // of its sessions [s]
  std::size_t cells = 0, first_visits = 0;      // first visits: with an error, in all its cells
  double within_jnd = 0;                        // of the first visits
  double clamped = 0, slewed = 0, outside = 0;  // shares of the frames
  double busy = 0;                              // saturation: share of the workers' time in solves
  double generated = 0;                         // energy given back beyond that received [J]
};
std::vector<StudyDevice> study_devices(const StudyPlan& plan, const std::vector<StudyCellResult>& cells);

// What must be said before the figures: devices of which more than 5 % of the frames are clamped or outside
// the box, or whose first visits are too few for a percentage.
std::vector<std::string> attention(const std::vector<StudyDevice>& devices);

}  // namespace forefeel
