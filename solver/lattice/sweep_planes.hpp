#pragma once
// The lattice planes of a sweep whose crossings are the coarse nodes: along each axis the even multiples of the spacing
// h and both ends of the box. Every lattice position between them lies halfway between two planes.

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

using LatticeIndex = std::array<int, 3>;  // x = h k

struct CoarsePlanes {
  std::array<std::vector<int>, 3> at;  // by axis, ascending

  bool holds(const LatticeIndex& k) const;  // a coarse node
  // The nearest planes with low <= q <= high; both are q on a plane; nothing outside of the box.
  std::optional<std::pair<int, int>> around(std::size_t axis, double q) const;
  // The next plane from the plane k to the lower (-1) or higher (1) side.
  std::optional<int> next(std::size_t axis, int k, int side) const;
};

// The node and the coarse nodes one plane nearer to rest along one or more axes: 1, 2, 4 or 8.
std::vector<LatticeIndex> inner_corners(const CoarsePlanes& planes, const LatticeIndex& coarse);

CoarsePlanes coarse_planes(const Box& box, double spacing);

}  // namespace forefeel
