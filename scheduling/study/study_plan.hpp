#pragma once
// Makes and checks the cells of a study before any of them runs. If a cell cannot run, the InputError names
// `study.speed`, `study.target_load`, `study.sustained` or a key of make_plan().

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "scheduling/session/session.hpp"
#include "scheduling/study/study.hpp"

namespace forefeel {

// The input and options of a session.
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
  // Used only with target_load and a hand, whose motion depends on the force. load_to_find: run_study() searches for
  // the cost that gives this load; 0: no search. free_demand: states per second that the motion needs if no force acts
  // on the hand.
  double load_to_find = 0, free_demand = 0;
  // Duration of the motion itself [s]; infinite for one without end. A session is no longer than its motion.
  double motion_seconds = std::numeric_limits<double>::infinity();
  std::vector<std::string> notes = {};  // on its motion: starts pressed in, leaves the box, rests
  // Identifies the content of the cell, to find its result on disk; empty: no result is kept.
  std::string key = {};
};

struct StudyPlan {
  Study study;
  std::vector<SessionInput> inputs;  // one for each combination
  std::vector<StudyCell> cells;      // StudyPlan::study.cells() of them, in their order
};

// Makes the whole plan: the three steps below for each cell.
StudyPlan plan_study(const Study& study, const StudySessions& sessions);

// 1. Makes a cell with the clock, seed and speed of the study.
StudyCell make_cell(const Study& study, std::size_t combination, std::uint64_t seed,
                    const SessionOptions& options);
// 2. Throws if make_plan() would refuse the session of the cell. If the motion is shorter than the session, the session
// ends with the motion: after a trace's own length, not with its last position held.
void check_cell(const Study& study, const SessionInput& input, StudyCell& cell);
// 3. Sets the cost of solves if the study varies target_load.
void set_cost(const Study& study, const SessionInput& input, StudyCell& cell);

// Number of lattice states that a motion needs per second: the corners, in the box, of every lattice cell that it
// passes. Rest is excluded if it is known from the start. This is the numerator of `load` (utilisation of the workers)
// in the summary. If visit_cell is set, cells of that side count, so that methods with lattices of different spacing
// get the same load.
double states_needed_per_second(const SessionInput& input, const SessionOptions& options);
// The cost model that gives `load`: log-normal with the sigma of the paper's times and mean c [s]. A worker
// delivers b states (a batch) in the time of their solves and two messages:
//   load = demand / (workers b / (c (1 + (b - 1) batch_share) + 2 latency))
// InputError if c is not positive (the messages alone exceed the load) or exceeds 1e6 s.
CostSpec cost_for_load(double load, const SessionOptions& options, double demand);
// The path device at that speed, printed as "path:NAME,…,speed=V". InputError with key `where` for a device that is not
// a path or that already has a speed.
DeviceSpec device_at_speed(const DeviceSpec& device, double speed, const std::string& where);

}  // namespace forefeel
