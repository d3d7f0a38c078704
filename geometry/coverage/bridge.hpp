#pragma once
// The sides of a bridge: clusters of the directions in which known states lie, seen from inside a gap (an unknown
// region between known ones). Two directions belong to one side if a chain of directions joins them in steps of at most
// the link angle. Two states at a distance h, seen from kappa_p h [m] or farther, are at most 2 asin(1 / (2 kappa_p))
// apart (39 degrees for kappa_p = 1.5). With that link angle, states of spacing h always form one side.

#include <functional>
#include <span>
#include <vector>

#include "geometry/coverage/region_summary.hpp"

namespace forefeel {

double bridge_link_deg(double sparse_distance);  // link angle [deg] for kappa_p

// offsets: states within the gap radius, relative to the place [m]. Nearest side first.
std::vector<BridgeSide> bridge_sides(std::span<const Vec3> offsets, double link_deg);

// Largest distance of a gap to its safe neighbours: the thickness kappa_p h of its sparse rim plus h/2 [m].
double rim_reach(double sparse_distance, double spacing);  // kappa_p, h [m]

// Fills RegionComponent::sides of the 1000 largest gaps, seen from their inner places. near: appends the states within
// the gap radius of a place, relative to it [m].
using StatesNear = std::function<void(const Vec3& place, std::vector<Vec3>& offsets)>;
void find_sides(std::vector<RegionComponent>& components, double sparse_distance, const StatesNear& near);

}  // namespace forefeel
