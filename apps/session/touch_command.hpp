#pragma once
// forefeel session of a scene with contact.anywhere.

#include <functional>
#include <memory>

#include "apps/session/session_arguments.hpp"

namespace forefeel {

// Returns the exit code. InputError for options that are about one place.
// gather: null without MPI; else waits for the other ranks and returns them.
int run_touch_command(const Globals& globals, const SessionArguments& given, const Scene& scene,
                      const std::function<std::shared_ptr<RankPool>()>& gather);

}  // namespace forefeel
