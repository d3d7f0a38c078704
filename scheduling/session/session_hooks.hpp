#pragma once
// Callbacks of run_session() while a session runs. Each may be empty.

#include <functional>

#include "scheduling/common/session_result.hpp"

namespace forefeel {

struct SessionHooks {
  ShowProgress progress = {};
  // Called once after the last frame, before labels and errors are added; these change `frames`, `switches`
  // and `notes`. Keep no reference: the result is moved later.
  std::function<void(const SessionResult&)> when_run = {};
  // Called with the HIP position of each frame, in order [m]. Runs on a separate thread, during the run if
  // possible.
  std::function<void(const Vec3&)> each_position = {};
};

}  // namespace forefeel
