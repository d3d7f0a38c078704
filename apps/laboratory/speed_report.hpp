#pragma once
// What `reproduce speed` found, and how it is shown.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/laboratory/speed_steps.hpp"

namespace forefeel {

struct Findings;  // reproduce.hpp

// What the damped switch alone leaves, whoever schedules (scheduling/study/speed_bound.hpp); means over the
// seeds, geometric ones of the speeds.
struct SpeedBounds {
  double guessed = 1, without = 1;  // with the first guess and without it [m/s]
  double known = 0;                 // from when on the force is known [s]
  double settled = 0;               // how long the force fades in then, after the guess [s]
  double settled_without = 0;       // the same after no force at all [s]
};

struct SpeedFindings {
  std::vector<int> workers;
  std::vector<std::vector<double>>
      speeds;  // [step][number of workers], geometric mean over the seeds; 0: below the least
  SpeedBounds bounds;
  double travel = 5;  // of each run [m]
  int seeds = 1;

  // Of the steps with this role the best for the w-th number of workers [m/s].
  double speed(SpeedRole role, std::size_t w) const;
};

void write_speed_csv(const std::filesystem::path& file, const SpeedFindings& found);
Findings speed_report(const SpeedFindings& found, const std::filesystem::path& folder);

}  // namespace forefeel
