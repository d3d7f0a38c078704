#pragma once
// The sides of a bridge: the directions in which known states lie, seen from inside a gap, in clusters. Two directions
// belong to one side where a chain of directions leads from one to the other in steps of at most the link angle. States
// h apart, seen from kappa_p h or farther, are no more than 2 asin(1 / (2 kappa_p)) apart (39 degrees for 1.5): with
// that link, populated areas of spacing h are never split.

#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "geometry/regions.hpp"

namespace forefeel {

double bridge_link_deg(double sparse_distance);   // kappa_p

// offsets: states within the gap radius, from the place that looks at them [m]. Nearest side first.
std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg);

// Fills safe_neighbours from which components touch which: directly, or through the sparse rim between them.
void name_safe_neighbours(const std::vector<std::set<std::uint32_t>>& beside, std::vector<RegionComponent>& components);

}  // namespace forefeel
