#pragma once
// Edges that grow with the distance from a contact. Wanted edge at y [m]:
//
//   h(y) = min(far, near + growth d),   d = max(0, |y - site| - radius)
//
// The mean volume of TetGen's tetrahedra is 0.15 h^3 (a regular one has 0.118 h^3), so a body B gets about
//
//   N = integral over B of dV / (0.15 h^3)
//
// tetrahedra. Only + - * / and square roots are used, so every processor computes the same bits.

#include <cstddef>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct SizeField {
  Vec3 site = Vec3::Zero();  // [m]
  double radius = 0;         // [m]
  double near = 0, far = 0;  // [m], near <= far
  double growth = 0.4;       // edge by distance

  double at(const Vec3& y) const { return at_distance((y - site).norm()); }
  double at_distance(double from_site) const;
};

// Edge l of the tetrahedra if `elements` of about equal size fill the body [m].
double uniform_edge(const Surface& closed, std::size_t elements);

// The field that gives about `elements` tetrahedra. The far edge is 1.5^(1/3) of the uniform one, and `near` takes the
// third of the elements that this leaves; of 1.15, 1.3, 1.6, 2 and 3 for 1.5, 1.3 and 1.6 gave the least errors of the
// stiffness, of linear and quadratic elements, 900 to 3,500 in number. Where `near` would then fall below `least_near`
// of the radius, the far edge is smaller instead. `near` never exceeds the uniform edge.
SizeField size_field(const Surface& closed, const Toward& toward, std::size_t elements);

inline constexpr double least_near = 0.1;

}  // namespace forefeel
