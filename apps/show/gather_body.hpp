#pragma once
// The body of a picture: from a scene, a mesh or a surface.

#include "apps/scene/scene.hpp"
#include "apps/show/show_content.hpp"
#include "geometry/meshing/surface.hpp"

namespace forefeel {

ShownBody shown_body(const Body& body);
ShownBody shown_body(const TetMesh& mesh);
ShownBody shown_body(const Surface& surface);

}  // namespace forefeel
