#pragma once
// Functions shared by the option checks.

#include <cmath>
#include <string>

#include "geometry/common/error.hpp"

namespace forefeel::detail {

// Throws InputError "session.KEY: PROBLEM" unless it holds.
inline void expect_option(bool holds, const char* key, const std::string& problem) {
  if (!holds) throw InputError(std::string("session.") + key, problem);
}

inline bool positive(double value) {
  return std::isfinite(value) && value > 0;
}

}  // namespace forefeel::detail
