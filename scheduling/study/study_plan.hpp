#pragma once
// The cells of a study, worked out and checked before anything runs. Where a cell cannot run the InputError
// names `study.speed`, `study.target_load`, `study.sustained`, or what make_plan() names.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scheduling/session/session.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

// What a session is made of.
struct StudySession {
  SessionInput input;
  SessionOptions options;
};
// The session of a combination: a value for each axis. Clock, seed and threads are the study's.
using StudySessions = std::function<StudySession(std::span<const std::size_t> choice)>;

struct StudyCell {
  std::vector<std::size_t> choice;  // value of each axis
  std::uint64_t seed = 0;
  std::size_t input = 0;   // into StudyPlan::inputs
  SessionOptions options;  // one thread; virtual clock
  // Only with target_load and a hand, whose motion answers the force: the load that run_study() finds the
  // cost for (0: none), and the states per second that the motion would need if nothing held the hand back.
  double load_to_find = 0, free_demand = 0;
  // Names the content of the cell, so that a result kept on disk is found again; empty: nothing is kept.
  std::string key = {};
};

struct StudyPlan {
  Study study;
  std::vector<SessionInput> inputs;  // one for each combination
  std::vector<StudyCell> cells;      // StudyPlan::study.cells() of them, in their order
};

// All at once: what the three steps below do for each cell.
StudyPlan plan_study(const Study& study, const StudySessions& sessions);

// 1. A cell with the clock, seed and speed of the study.
StudyCell make_cell(const Study& study, std::size_t combination, std::uint64_t seed,
                    const SessionOptions& options);
// 2. Throws for what a session of the cell would refuse.
void check_cell(const Study& study, const StudyCell& cell, const SessionInput& input);
// 3. The cost of its solves where the study varies target_load.
void set_cost(const Study& study, const SessionInput& input, StudyCell& cell);

// Lattice states that a motion needs per second: the corners, in the box, of every lattice cell that it
// passes. Rest is left out where it is known from the start. This is the numerator of the summary's `load`.
// Where visit_cell is set its cells count, so that methods on lattices of different spacing bear the same
// load.
double states_needed_per_second(const SessionInput& input, const SessionOptions& options);
// Cost model under which `load` holds: log-normal with the spread of the paper's times and mean c [s], where
// a worker gives b states (the batch) in the time of their solves and a message each way:
//   load = demand / (workers b / (c (1 + (b - 1) batch_share) + 2 latency))
// InputError where c is not above 0 (the messages alone are more than the load) or is more than 1e6 s.
CostSpec cost_for_load(double load, const SessionOptions& options, double demand);
// The path at that speed, printed as "path:NAME,…,speed=V". InputError names `where` for a device that is no
// path or that names its speed already.
DeviceSpec device_at_speed(const DeviceSpec& device, double speed, const std::string& where);

}  // namespace forefeel
