#pragma once
// How far each element locks: force at a given depth over Poisson's ratio, beside a refined quadratic reference.

#include "apps/console/console.hpp"

namespace forefeel {

int bench_elements(const Globals& globals);  // `forefeel bench solver elements`

}  // namespace forefeel
