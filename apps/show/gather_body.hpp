#pragma once
// The body of a picture: from a scene, a mesh or a surface.

#include "apps/scene/scene.hpp"
#include "apps/show/show_content.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct Globals;

ShownBody shown_body(const Body& body);
// Of a scene with contact.anywhere, coloured by its stiffness at rest.
ShownBody shown_anywhere(const Scene& scene, const Globals& globals);
ShownBody shown_body(const TetMesh& mesh);
ShownBody shown_body(const Surface& surface);

}  // namespace forefeel
