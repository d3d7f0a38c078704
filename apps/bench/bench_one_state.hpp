#pragma once
// Cost of the first state of a large body: time, including the analysis of the matrix, and memory.

#include <memory>
#include <string>

#include "apps/console/console.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// `forefeel bench solver SCENE --states 1`.
int bench_one_state(const Globals& globals, std::shared_ptr<const Body> body, double spacing,
                    const std::string& scene);

}  // namespace forefeel
