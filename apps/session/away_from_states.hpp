#pragma once
// How far the hand of a session was from the states of another body (measured forces), and what that costs.

#include <functional>
#include <string_view>

#include "scheduling/record/summary.hpp"

namespace forefeel {

struct SessionPlan;
struct SessionResult;

// Distances of at most 5,000 frames from the nearest usable state, and medians of the 95 % bars that `evaluate` finds
// from the states: at up to 100 frames, each with the distance of the newest model's force from that of `evaluate`, and
// at up to 100 states. Empty unless the states are of another body. Where the field of measured forces was rendered,
// the frames take these bars, about the rendered force. write: writes the frames; called before
// the bars, which take seconds and may be cut short, and again when they have changed. show: what is being done, and
// its share done.
SessionSummary::AwayFromStates away_from_states(
    SessionResult& result, const SessionPlan& plan, const std::function<void()>& write,
    const std::function<void(std::string_view, double)>& show = {});

}  // namespace forefeel
