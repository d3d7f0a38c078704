#pragma once
// What a caller of run_session() is told while a session runs. Each may be empty.

#include <functional>

#include "scheduling/log/session_result.hpp"

namespace forefeel {

struct SessionHooks {
  ShowProgress progress = {};
  // Called once after the last frame, before labels and errors are entered, which change `frames`, `switches`
  // and `notes`. The result moves: keep no reference to it.
  std::function<void(const SessionResult&)> when_run = {};
  // Where the HIP was in each frame, in order [m]; on a thread of its own, beside the run where that can be.
  std::function<void(const Vec3&)> each_position = {};
};

}  // namespace forefeel
