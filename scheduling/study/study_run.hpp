#pragma once
// Runs the cells of a study in parallel. The result depends neither on the number of threads nor on
// interruptions and resumes.

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "scheduling/study/cell_result.hpp"
#include "scheduling/study/study_plan.hpp"

namespace forefeel {

// Storage of results between runs. Both functions are called from several threads at once.
struct StudyStore {
  // nullopt if the cell is not stored
  std::function<std::optional<StudyCellResult>(const StudyCell&)> load = {};
  // Called as soon as a cell is done.
  std::function<void(const StudyCell&, const StudyCellResult&)> save = {};
};

struct StudyProgress {
  double share = 0;  // of all cells that are run, in [0, 1]
  std::size_t done = 0, cells = 0, resumed = 0;
};

// The cells number - 1, number - 1 + of, … of a plan: of several machines, each runs its own part. number 0: none.
struct StudyPart {
  std::size_t number = 1, of = 1;
  bool has(std::size_t cell) const { return cell % of == number - 1; }
};

struct StudyRunOptions {
  int threads = 0;  // 0: all cores
  StudyStore store = {};
  // Once interrupted is true, the run drops unfinished cells and ends. Once hurried is true, it does not wait
  // for reference solves either.
  const std::atomic<bool>* interrupted = nullptr;
  const std::atomic<bool>* hurried = nullptr;
  std::function<void(const StudyProgress&)> progress = {};
  std::function<void(const std::string&)> warn = {};
  StudyPart part = {};
};

struct StudyResult {
  std::vector<StudyCellResult> cells;  // as StudyPlan::cells; empty for cells not done
  std::size_t ran = 0, resumed = 0;
  std::size_t of_other_parts = 0;  // cells not done that another part runs
  bool interrupted = false;
  double seconds = 0;  // wall time [s]
};

// Sessions of a study failed, for example because a policy threw. The line names the first such cell.
struct StudyFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A cell whose session fails does not stop the others; at the end StudyFailure is thrown. Other exceptions of sessions
// end the study. Results of finished cells stay stored in both cases.
StudyResult run_study(const StudyPlan& plan, const StudyRunOptions& options);

// Finds the cost that gives the cell's load_to_find (load: utilisation of the workers). The force of a body slows a
// hand, so the hand needs fewer states than in free motion; only the session shows how many. So the session is
// simulated and the cost corrected until the load is within 2.5 % of the requested one. The nearest of at most 12 tries
// is used. A cell without load_to_find is returned unchanged.
StudyCell with_load_found(const StudyCell& cell, const SessionInput& input);
// One line of warning if cells with a hand still miss their load by more than 5 %; else nullopt.
std::optional<std::string> loads_missed(const StudyPlan& plan, const std::vector<StudyCellResult>& cells);

}  // namespace forefeel
