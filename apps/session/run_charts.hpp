#pragma once
// Parts of a session's report: the charts that its script draws, and the table of its worst moments.

#include <string>

#include "apps/session/run_view.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

// Curves over time, a view around each switch, maps of the errors, with data and script. without_script: HTML
// that browsers without scripts show instead.
std::string run_charts(const SessionResult& result, const RunView& view, const std::string& without_script);
std::string worst_moments(const SessionResult& result, const RunView& view);

}  // namespace forefeel
