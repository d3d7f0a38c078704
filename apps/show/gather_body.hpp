#pragma once
// The body of a picture: from a scene, a mesh or a surface.

#include <optional>
#include <span>
#include <vector>

#include "apps/scene/palpation_map.hpp"
#include "apps/scene/scene.hpp"
#include "apps/show/show_content.hpp"
#include "geometry/meshing/surface.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// The regions of a body's picture: its materials, or the groups of tetrahedra of a mesh.

// Fills the regions of a shown body, whose mesh and surface are there. Positions are still those of the mesh.
void take_regions(const Body& body, ShownBody& shown);
// A tetrahedron in several groups counts for the first by name. One group of all tetrahedra is no region.
void take_regions(const TetMesh& mesh, ShownBody& shown);

// Where the springs of a pad act on the surface of a picture, or how stiff the body is under a pad anywhere.

// The facets under the pad, split until a side is at most an eighth of the pad's radius. nullopt without a pad.
std::optional<ShownPad> shown_pad(const Body& body, const ShownBody& shown);
// The stiffness at rest of the body without the pad, at the nodes of the surface: it shows more than with it. nullopt
// where all is clamped.
std::optional<ShownPad> shown_stiffness(const std::vector<SurfaceStiffness>& map, const ShownBody& shown);
// The estimated error at this depth [m]: full colour where the force is not trusted.
std::optional<ShownPad> shown_error(const std::vector<SurfaceError>& map, double tolerance, double depth,
                                    const ShownBody& shown);

struct Globals;

ShownBody shown_body(const Body& body);
// Of a scene with contact.anywhere, coloured by its stiffness at rest, or by the estimated error of the force at the
// depth `trust` [m], from the field and these states.
ShownBody shown_anywhere(const Scene& scene, const Globals& globals, std::optional<double> trust,
                         std::span<const State> states);
ShownBody shown_body(const TetMesh& mesh);
ShownBody shown_body(const Surface& surface);

}  // namespace forefeel
