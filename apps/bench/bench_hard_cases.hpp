#pragma once
// The table of hard cases: laws x Poisson's ratio x contact x motion on the liver phantom, and bodies of
// unusual size, stiffness and shape.

#include "apps/console/console.hpp"

namespace forefeel {

// `forefeel bench solver hard-cases`; output: a folder for hard_cases.csv and hard_cases.html; empty writes
// no file.
int bench_hard_cases(const Globals& globals, const std::string& output);

}  // namespace forefeel
