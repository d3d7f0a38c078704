#pragma once
// Tight solves at many positions, by all threads, with progress. What is solved is kept in the cache folder until all
// is: a run that was killed is resumed by the same command.

#include <optional>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

// In the order of the points [m]. site: of a pad anywhere [m]; jet: order of the force.
std::vector<SolveOutcome> solve_all(const Scene& scene, const std::vector<Vec3>& points,
                                    const std::optional<Vec3>& site, int jet, const Globals& globals);

}  // namespace forefeel
