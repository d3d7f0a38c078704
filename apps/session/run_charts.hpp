#pragma once
// Parts of a session's report: the charts that its script draws, and the table of its worst moments.

#include <string>

#include "apps/session/run_view.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

// The data that the script of a session's report draws (run_chart.js, run_page.js), as one JSON document: |force| and
// position of the frames as base64 of 32-bit floats, other data as short lists of times and values.

// Long runs keep every k-th frame, at most 60,000.
std::string run_data(const SessionResult& result, const RunView& view);

// Curves over time, a view around each switch, maps of the errors, with data and script. without_script: HTML
// that browsers without scripts show instead.
std::string run_charts(const SessionResult& result, const RunView& view, const std::string& without_script);
std::string worst_moments(const SessionResult& result, const RunView& view);

}  // namespace forefeel
