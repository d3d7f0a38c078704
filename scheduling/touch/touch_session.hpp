#pragma once
// A session in which a body is touched anywhere: the loop renders the field of jets at rest and the states solved so
// far at the tip's site, while workers solve what the planner wants. Under the virtual clock loop and workers are
// simulated, and results repeat bit by bit; under the real clock each is a thread.
// After the run every sampled frame is compared with a tight solve at its site (touch_judge.hpp).

#include "scheduling/session/session_options.hpp"
#include "scheduling/touch/touch_result.hpp"

namespace forefeel {

// InputError for what cannot run; the device is made, and nothing else.
void check_touch_session(const TouchSessionInput& input, const SessionOptions& options);

// InputError for what cannot run. progress: called by one thread at a time.
TouchSessionResult run_touch_session(const TouchSessionInput& input, const SessionOptions& options,
                                     const std::function<void(const TouchProgress&)>& progress = {});

}  // namespace forefeel
