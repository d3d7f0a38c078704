#pragma once
// The sides of a bridge: clusters of the directions in which known states lie, seen from inside a gap. Two
// directions belong to one side if a chain of directions joins them in steps of at most the link angle.
// States h apart, seen from kappa_p h or farther, are at most 2 asin(1 / (2 kappa_p)) apart (39 degrees for
// 1.5): with that link angle an area of spacing h is never split.

#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

double bridge_link_deg(double sparse_distance);  // link angle [deg] for kappa_p

// offsets: states within the gap radius, relative to the place [m]. Nearest side first.
std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg);

// How far from a gap its safe neighbours may lie: the thickness kappa_p h of its sparse rim plus h/2 [m].
double rim_reach(double sparse_distance, double spacing);  // kappa_p, h [m]

// Fills safe_neighbours. beside: the components that share a facet with each; near_safe: the safe components
// within rim_reach() of each gap.
void name_safe_neighbours(const std::vector<std::set<std::uint32_t>>& beside,
                          std::vector<std::set<std::uint32_t>>& near_safe,
                          std::vector<RegionComponent>& components);

}  // namespace forefeel
