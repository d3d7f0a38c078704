#pragma once
// What a triangle surface is made of, and whether it is closed: every edge belongs to exactly two triangles.

#include <cstddef>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct SurfaceSummary {
  std::size_t nodes = 0, triangles = 0;
  std::size_t border_edges = 0;        // of one triangle
  std::size_t non_manifold_edges = 0;  // of more than two
  double volume = 0;                   // [m^3]; NaN if the surface is not closed
  Box box;                             // [m]

  bool closed() const { return border_edges == 0 && non_manifold_edges == 0; }
};

SurfaceSummary summarise(const Surface& surface);

}  // namespace forefeel
