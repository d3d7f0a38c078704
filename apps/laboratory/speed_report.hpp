#pragma once
// The results of `reproduce speed` and their presentation.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/laboratory/speed_steps.hpp"

namespace forefeel {

struct Findings;  // reproduce.hpp

// Upper bound of the speed: the session has the exact force everywhere as soon as a solve can be finished, so only the
// damped switch limits it (scheduling/study/speed_bound.hpp). Means over the seeds; geometric means of speeds.
struct SpeedBounds {
  double guessed = 1, without = 1;  // bound with and without the first guess [m/s]
  double known = 0;                 // time from which the force is known [s]
  double settled = 0;               // duration of the fade-in after that, starting from the guess [s]
  double settled_without = 0;       // the same, starting from zero force [s]
};

struct SpeedFindings {
  std::vector<int> workers;
  std::vector<std::vector<double>>
      speeds;  // [step][number of workers], geometric mean over the seeds; 0: below the lowest speed tried
  SpeedBounds bounds;
  double travel = 5;  // path length of each run [m]
  int seeds = 1;

  // Best speed among the steps with this role, for the w-th number of workers [m/s].
  double speed(SpeedRole role, std::size_t w) const;
};

void write_speed_csv(const std::filesystem::path& file, const SpeedFindings& found);
Findings speed_report(const SpeedFindings& found, const std::filesystem::path& folder);

}  // namespace forefeel
