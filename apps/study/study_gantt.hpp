#pragma once
// Gantt chart of the solves: one row per worker, one bar per solve. The colour is the label of the region
// that the state was planned for.

#include <string>

#include "apps/session/report_figures.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

// Bars of cancelled solves are thin; bars of states that no model used have half the height. The lowest row
// shows the label at the HIP.
Figure gantt_figure(const SessionResult& result, double seconds, int workers);

}  // namespace forefeel
