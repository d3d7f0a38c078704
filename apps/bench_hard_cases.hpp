#pragma once
// The table of hard cases: laws x Poisson's ratio x contact x motion on the liver phantom, and bodies of odd size,
// stiffness and shape.

#include "apps/command.hpp"

namespace forefeel {

int bench_hard_cases(const Globals& globals);    // `forefeel bench solver hard-cases`

}  // namespace forefeel
