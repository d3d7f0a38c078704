#pragma once
// The sides of a bridge: the directions in which known states lie, seen from inside a gap, in clusters. Two directions
// belong to one side where a chain of directions leads from one to the other in steps of at most the link angle. States
// h apart, seen from kappa_p h or farther, are no more than 2 asin(1 / (2 kappa_p)) apart (39 degrees for 1.5): with
// that link, populated areas of spacing h are never split.

#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "geometry/coverage/regions.hpp"

namespace forefeel {

double bridge_link_deg(double sparse_distance);  // kappa_p

// offsets: states within the gap radius, from the place that looks at them [m]. Nearest side first.
std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg);

// How far from a gap the safe parts lie that it meets: behind its sparse rim, kappa_p h thick, and half a spacing [m].
double rim_reach(double sparse_distance, double spacing);  // kappa_p, h [m]

// Fills safe_neighbours from which components share facets, and which safe ones lie within the rim's reach of each gap.
void name_safe_neighbours(const std::vector<std::set<std::uint32_t>>& beside,
                          std::vector<std::set<std::uint32_t>>& near_safe,
                          std::vector<RegionComponent>& components);

}  // namespace forefeel
