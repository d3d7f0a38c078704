#pragma once
// Runs the cells of a study that are not there yet, in parallel, and keeps each as a file of its own the
// moment it is done: DIR/cells/KEY.json, written whole or not at all. A kill loses only the cells under way.
// KEY is the content of the cell (scene, body, options, seed, traces, version), so a cell is found again
// whatever else of the study changes, and never mistaken for another.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/study/study_plan.hpp"

namespace forefeel {

// What a cell leaves: session keys joined by dots -> number, text, or null; in a fixed order.
using CellColumns = nlohmann::ordered_json;

struct StudyResult {
  std::vector<CellColumns> cells;  // as StudyPlan::cells
  std::size_t ran = 0, resumed = 0;
  bool interrupted = false;  // by a signal: cells that were not done are empty
  double seconds = 0;        // wall
};

// Of one session: the summary flattened, and what a study adds to it:
//   solver.busy, solver.preempted, solver.wasted   seconds of the workers: in all; in cancelled solves; in
//   solves
//                                                  that no model used
//   states.used_share                              of solved states
//   error.first_visit.parts.…                      p95 over first visits, as error.parts is over all samples
//   error.first_visit.within_7                     share of first visits within 7 % of the reference force
// Values that depend on wall time stay empty.
CellColumns cell_columns(const SessionResult& result, const SessionInput& input,
                         const SessionOptions& options);

// A first SIGINT or SIGTERM ends it: the cells done stay, those under way are left out.
// Another process that writes to the same folder is refused. Throws what a session throws; cells done stay.
StudyResult run_study(const StudyPlan& plan, const std::filesystem::path& folder, const Globals& globals);

// The cell with the cost that its load takes: where a body holds a hand back, the hand needs fewer states than it would alone,
// by how much shows only in the session. It is rehearsed, the cost corrected by what was measured, until the load is within
// 2.5 % of the one asked for; of 12 tries the nearest counts. Other cells come back as they are.
StudyCell with_load_found(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input);
// One line where cells of a hand miss their load by more than 5 % all the same (a session of few solves); else nothing.
std::optional<std::string> loads_missed(const StudyPlan& plan, const std::vector<CellColumns>& cells);

// The session of one cell; sessions of one study may share a reference service (see study_references).
SessionResult run_cell(const StudyPlan& plan, const StudyCell& cell, const SessionInput& input,
                       const std::function<void(const SessionProgress&)>& progress);

}  // namespace forefeel
