#pragma once
// Locking of each element type: force at a given depth as a function of Poisson's ratio, compared with a
// refined quadratic reference.

#include "apps/console/console.hpp"

namespace forefeel {

int bench_elements(const Globals& globals);  // `forefeel bench solver elements`

}  // namespace forefeel
