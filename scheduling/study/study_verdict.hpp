#pragma once
// The result of a study in one sentence, advice for the next study, and a table of its devices.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/study_plan.hpp"
#include "scheduling/study/study_ranking.hpp"

namespace forefeel {

// "Best policy: coverage, with 93.1 % of first visits within the JND …: the difference is significant." It compares the
// values of the axis of policies, or else of the first axis with two values; nothing if there is none. Policies that
// know the motion (clairvoyant …) are upper bounds and are not compared. A difference is significant if both 95 %
// intervals exclude zero and its p value, adjusted by Holm over all compared with the best, is at most 0.05.
std::optional<std::string> study_verdict(const Study& study, const std::vector<StudyCellResult>& cells);

// Advice for the next study, one line each: how many more motions would make the difference significant; whether the
// difference is hidden because nearly all values are at their maximum or minimum; and at which load (utilisation of the
// workers) to repeat the study. Empty if no axis has two values.
std::vector<std::string> study_advice(const Study& study, const std::vector<StudyCellResult>& cells);

// One device (a value of the axis `device`, or the device of all cells): means over its cells. Shares in [0,
// 1]; NaN where no cell has a value.
struct StudyDevice {
  std::string device;
  double motion_seconds = 0;                    // of the motion itself [s]; infinite for one without end
  double seconds = 0;                           // of its sessions [s]
  std::size_t cells = 0, first_visits = 0;      // first visits: with an error, in all its cells
  std::size_t unstable = 0;                     // cells with an instability of the loop
  double within_jnd = 0;                        // of the first visits
  double clamped = 0, slewed = 0, outside = 0;  // shares of the frames
  double busy = 0;                              // saturation: share of the workers' time in solves
  double generated = 0;                         // energy given back beyond that received [J]
};
std::vector<StudyDevice> study_devices(const StudyPlan& plan, const std::vector<StudyCellResult>& cells);

// Warnings to print before the figures: unstable sessions, devices with more than 5 % of the frames clamped or outside
// the box, or with too few first visits for a percentage.
std::vector<std::string> attention(const std::vector<StudyDevice>& devices);

}  // namespace forefeel
