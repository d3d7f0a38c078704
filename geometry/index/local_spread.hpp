#pragma once
// The spread of a place q, computed from the states x_j around it, without a triangulation:
//   pi_rho(q) = min { sqrt(sum mu_j |x_j - q|^2) :
//                     mu_j >= 0, sum mu_j = 1, sum mu_j x_j = q,  |x_j - q| <= rho }   [m]
// The spread of delaunay_index.hpp is the same minimum over all states. So pi <= pi_rho, with equality if the
// corners of the Delaunay cell of q lie within rho. pi_rho is finite if q lies in the hull of the states within
// rho. This is a linear programme with five rows, solved by the simplex method on tetrahedra: about ten pivots,
// O(n) each.

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "geometry/common/types.hpp"

namespace forefeel {

struct LocalSpread {
  double spread = std::numeric_limits<double>::infinity();  // [m]
  bool solid = false;                     // true: the four corners are states and not coplanar
  std::array<std::uint32_t, 4> corner{};  // indices of the optimal tetrahedron
};

// offsets: x_j - q [m]; scale: a length of their order of magnitude [m].
LocalSpread least_spread(std::span<const Vec3> offsets, double scale);

// Of the ball through four places that are not coplanar [m].
double circumradius(const std::array<Vec3, 4>& corner);

}  // namespace forefeel
