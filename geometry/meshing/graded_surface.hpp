#pragma once
// Remeshes a closed surface so that its edges are h(y) long (size_field.hpp), with given lines kept as edges. Rounds of
// splitting edges above 4/3 h, collapsing those below 4/5 h, flipping to Delaunay and moving nodes along the surface
// (Botsch and Kobbelt 2004, A remeshing approach to multiresolution modeling). Nodes lie on the exact surface, those of
// lines on the lines. The mean edge comes out at 0.7 to 1 h. Deterministic. Private to this room.

#include <array>
#include <functional>
#include <vector>

#include "geometry/meshing/size_field.hpp"

namespace forefeel {

using Link = std::array<NodeIndex, 2>;  // an edge, lower node first

struct GradedInput {
  Surface start;  // closed, manifold, outward
  std::vector<Link> sharp = {},
                    rim = {};  // edges of start that stay lines of edges; sorted, in one of them only
  std::vector<NodeIndex> corners = {};  // nodes of start that stay where they are, sorted
  // The exact place of a node near the surface, near a sharp edge, near the rim.
  std::function<Vec3(const Vec3&)> onto = {}, onto_sharp = {}, onto_rim = {};
  SizeField size = {};
};

struct GradedSurface {
  Surface surface;
  std::vector<char> held;                      // 1 for nodes of lines and for corners
  std::function<Vec3(const Vec3&)> onto = {};  // as of the input
};

GradedSurface graded_surface(const GradedInput& input);

}  // namespace forefeel
