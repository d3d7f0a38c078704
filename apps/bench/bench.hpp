#pragma once
// The four benches of `forefeel bench`: each prints its rows and returns the exit code. scene "": the
// built-in one.

#include <cstddef>
#include <string>

#include "apps/console/console.hpp"

namespace forefeel {

// folder: for approx.csv and approx.svg; "" writes none.
int bench_approx(const Globals& globals, const std::string& scene, const std::string& folder);
int bench_coverage(const Globals& globals);
// most_states: 0 for the scene's whole lattice.
int bench_solver(const Globals& globals, const std::string& scene, std::size_t most_states);
int bench_switch(const Globals& globals, const std::string& scene);

}  // namespace forefeel
