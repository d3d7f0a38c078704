#pragma once
// The pictures of a run's report, as gnuplot scripts (see plot.hpp). `rendered` and `sent` are those of
// scheduling/record/summary.hpp: before and after the safety rules.

#include <span>
#include <string>
#include <vector>

#include "apps/picture/figure.hpp"
#include "apps/session/run_view.hpp"
#include "scheduling/common/session_result.hpp"
#include "solver/jet/surface_map.hpp"

namespace forefeel {

// Over one time axis: force with its limit and the steps that a hand feels [N], labels, number of known states, error
// and its parts. A limit above the axis is named instead of drawn; NaN: none.
Figure time_figure(const SessionResult& result, const RunView& view);
// Cost and wake-up lateness of the loop; only with a real clock.
bool has_deadlines(std::span<const FrameRecord> frames);
Figure deadline_figure(std::span<const FrameRecord> frames);

// The surface in grey, the sites of a body that was touched anywhere in the colour of the error there; seen along two
// axes.
Figure site_figure(std::span<const FrameRecord> frames, const SurfaceMap& surface);

}  // namespace forefeel
