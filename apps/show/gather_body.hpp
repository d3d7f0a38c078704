#pragma once
// The body of a picture: from a scene, a mesh or a surface.

#include <optional>
#include <span>

#include "apps/scene/scene.hpp"
#include "apps/show/show_content.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct Globals;

ShownBody shown_body(const Body& body);
// Of a scene with contact.anywhere, coloured by its stiffness at rest, or by the estimated error of the force at the
// depth `trust` [m], from the field and these states.
ShownBody shown_anywhere(const Scene& scene, const Globals& globals, std::optional<double> trust,
                         std::span<const State> states);
ShownBody shown_body(const TetMesh& mesh);
ShownBody shown_body(const Surface& surface);

}  // namespace forefeel
