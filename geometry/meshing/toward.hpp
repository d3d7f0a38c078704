#pragma once
// What a mesh is made for: the contact that it is fine at, and the clamp whose rim is an edge of it.

#include "geometry/common/types.hpp"

namespace forefeel {

// The ball of a contact. Elements are small in it and grow with the distance from it (size_field.hpp).
struct Toward {
  Vec3 site = Vec3::Zero();  // [m]; taken to the nearest point of the surface
  double radius = 0;         // [m]
};

// The part of a body at the low end of an axis, as nodes_below() chooses its nodes (tet_mesh.hpp). Its rim is the
// surface's section with the plane at `share` of the extent.
struct LowEnd {
  Axis axis = Axis::z;
  double share = 0;  // between 0 and 1
};

}  // namespace forefeel
