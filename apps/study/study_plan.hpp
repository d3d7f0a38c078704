#pragma once
// The cells of a study, worked out and checked before anything runs or is written.

#include <filesystem>
#include <string>
#include <vector>

#include "apps/scene_input/scene_session.hpp"
#include "apps/study/study.hpp"

namespace forefeel {

struct StudyCell {
  std::vector<std::size_t> choice;  // value of each axis
  std::uint64_t seed = 0;
  std::size_t scene = 0;   // into StudyPlan::scenes
  SessionOptions options;  // of the session; threads 1
  // Of a hand, whose motion answers the force: the load that a rehearsal is to find the cost for (0: none), and what the
  // motion would need if nothing held the hand back [states/s].
  double load_to_find = 0, free_demand = 0;
  std::string key;  // SHA-256 of everything that its result depends on
};

struct StudyPlan {
  Study study;
  std::vector<Scene> scenes;     // one for each combination; bodies are shared where they are the same
  std::vector<StudyCell> cells;  // in the order of cells.csv
  std::vector<std::string> warnings;
};

// InputError names the place in the study for whatever a cell could not run with.
StudyPlan plan_study(Study study);

// States of the lattice that a motion needs, the corners in the box of every lattice cell it passes, per
// second, rest left out where it is known from the start: the numerator of the summary's `load`. Where visit_cell is
// set its cells count, so that methods on lattices of different spacing bear the same load.
double states_needed_per_second(const Scene& scene, const SessionOptions& options);
// Cost model under which `load` holds: log-normal with the spread of the paper's times and mean c, where a
// worker gives b states (the batch) in the time of their solves and a message each way:
//   load = demand / (workers b / (c (1 + (b - 1) batch_share) + 2 latency))
// InputError at `where` where c is not above 0 (the messages alone are more than the load) or is more than 1e6 s.
std::string cost_for_load(double load, const SessionOptions& options, double demand, const InputPlace& where);
// "path:NAME,speed=V"; InputError for a device that is no path or that names its speed already.
std::string device_at_speed(const std::string& device, double speed, const InputPlace& where);

}  // namespace forefeel
