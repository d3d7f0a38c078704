#pragma once
// The data that the script of a session's report draws (run_chart.js, run_page.js), as one JSON document: |force| and
// position of the frames as base64 of 32-bit floats, other data as short lists of times and values.

#include <string>

#include "apps/session/run_view.hpp"
#include "scheduling/common/session_result.hpp"

namespace forefeel {

// Long runs keep every k-th frame, at most 60,000.
std::string run_data(const SessionResult& result, const RunView& view);

}  // namespace forefeel
