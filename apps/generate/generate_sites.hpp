#pragma once
// forefeel generate of a scene with contact.anywhere: the field at rest over the surface, kept in the cache, and states
// solved at random sites and displacements, which say how far it is right. The file holds the field's jets (x = 0) and
// these states.

#include <optional>
#include <string>

#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"

namespace forefeel {

struct GenerateSites {
  std::string output;
  std::string where;            // the part of the surface: x/y/z/radius, or a node group; empty: all
  std::optional<double> error;  // p95 that is wanted [1]
};

// Returns the exit code: 1 where the error is above the one wanted, or where it was interrupted. ranks: that solve,
// too; null: threads.
int generate_sites(const Globals& globals, const Scene& scene, const GenerateSites& wanted, RankPool* ranks);

}  // namespace forefeel
