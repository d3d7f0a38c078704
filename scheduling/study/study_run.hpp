#pragma once
// Runs the cells of a study in parallel. A result is the same however many threads run it and however often
// it is resumed.

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/study/cell_result.hpp"
#include "scheduling/study/study_plan.hpp"

namespace forefeel {

// Where results are kept from run to run. Both are called from several threads at a time.
struct StudyStore {
  std::function<std::optional<StudyCellResult>(const StudyCell&)> load =
      {};  // nothing where the cell is not there
  std::function<void(const StudyCell&, const StudyCellResult&)> save = {};  // the moment a cell is done
};

struct StudyProgress {
  double share = 0;  // of all cells that are run, in [0, 1]
  std::size_t done = 0, cells = 0, resumed = 0;
};

struct StudyRunOptions {
  int threads = 0;  // 0: all cores
  StudyStore store = {};
  // Once interrupted is true the cells under way are left out and the run ends; once hurried is true it does
  // not even wait for reference solves.
  const std::atomic<bool>* interrupted = nullptr;
  const std::atomic<bool>* hurried = nullptr;
  std::function<void(const StudyProgress&)> progress = {};
  std::function<void(const std::string&)> warn = {};
};

struct StudyResult {
  std::vector<StudyCellResult>
      cells;  // as StudyPlan::cells; of an interrupted study those not done are empty
  std::size_t ran = 0, resumed = 0;
  bool interrupted = false;
  double seconds = 0;  // wall
};

// Throws what a session throws; results of cells that are done are kept.
StudyResult run_study(const StudyPlan& plan, const StudyRunOptions& options);

// The cell with the cost that its load takes. Where a body holds a hand back, the hand needs fewer states
// than it would alone; how many shows only in the session. The session is simulated and the cost corrected
// until the load is within 2.5 % of the one asked for; the nearest of at most 12 tries counts. Other cells
// come back as they are.
StudyCell with_load_found(const StudyCell& cell, const SessionInput& input);
// One line where cells with a hand miss their load by more than 5 % all the same; else nothing.
std::optional<std::string> loads_missed(const StudyPlan& plan, const std::vector<StudyCellResult>& cells);

}  // namespace forefeel
