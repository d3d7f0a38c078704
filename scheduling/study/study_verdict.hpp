#pragma once
// The result of a study in a sentence, and what its figures rest on, device by device.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/study_plan.hpp"
#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// "Best policy: coverage, with 93.1 % of first visits within the JND …: the difference is significant." For
// the axis of policies, or else the first axis with two values; nothing if there is none. Policies that know
// the motion (clairvoyant …) are upper bounds: they do not compete. A difference is significant if both 95 %
// intervals exclude zero.
std::optional<std::string> study_verdict(const Study& study, const std::vector<StudyCellResult>& cells);

// What to do next, one line each: how many more motions would show the difference that the verdict does not
// show, whether a ceiling or a floor hides it, and at which load to look. Empty if no axis has two values.
std::vector<std::string> study_advice(const Study& study, const std::vector<StudyCellResult>& cells);

// Motions (groups) for which both ends of Student's 95 % interval of this difference lie on one side of zero
// with a chance of 80 %, if mean and spread stay as they are; nothing if one group gives no spread, or the
// mean is zero, or a thousand are not enough.
std::optional<std::size_t> motions_needed(const Comparison& difference);

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
