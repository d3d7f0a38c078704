#pragma once
// The order of positions along a Z-curve (Morton order): neighbours in the order are close in space. An
// insertion into the triangulation then starts one or two cells from its place.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/states/state.hpp"

namespace forefeel {

// Indices of the states. Cells of side `spacing` [m], counted from the low corner of the box; equal cells
// keep the order of the states. O(n log n).
std::vector<std::uint32_t> morton_order(std::span<const State> states, const Box& box, double spacing);
std::vector<std::uint32_t> morton_order(std::span<const Vec3> at, const Box& box, double spacing);

}  // namespace forefeel
