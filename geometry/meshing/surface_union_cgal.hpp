#pragma once
// Unites the parts of a closed surface that cross each other, such as segments that were appended to one file: the body
// is what any of them encloses. Parts that lie apart, or one inside another, stay as they are.

#include <cstddef>

#include "geometry/meshing/surface_cgal.hpp"

namespace forefeel::cgal {

// Number of parts that cross another one. 0: the mesh is unchanged. Otherwise `united` says whether the mesh is now
// their union; false if a part crosses itself or CGAL's corefinement fails, and then the mesh is unchanged, too.
std::size_t unite_crossing_parts(Mesh& mesh, bool& united);

}  // namespace forefeel::cgal
