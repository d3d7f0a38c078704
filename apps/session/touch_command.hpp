#pragma once
// forefeel session of a scene with contact.anywhere.

#include "apps/session/session_arguments.hpp"

namespace forefeel {

// Returns the exit code. InputError for options that are about one place.
int run_touch_command(const Globals& globals, const SessionArguments& given, const Scene& scene);

}  // namespace forefeel
