#pragma once
// One state of a large body: what it costs from nothing, analysis and memory included.

#include <memory>
#include <string>

#include "apps/console/console.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// `forefeel bench solver SCENE --states 1`.
int bench_one_state(const Globals& globals, std::shared_ptr<const Body> body, double spacing,
                    const std::string& scene);

}  // namespace forefeel
