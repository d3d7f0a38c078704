#pragma once
// Energy that a force field f [N] generates or dissipates around a closed loop x_k [m], k = 0 … m, x_m = x_0:
//   net   = |sum_k 1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
//   gross = sum_k |1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
// For a conservative field net is 0 up to the quadrature error. The quadrature is exact for f = -K x with
// symmetric K and of order m^-2 or better otherwise (better than any power of m on a smooth loop in a smooth
// field). net / gross is the share of its work that a hand gains or loses in each turn.

#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct LoopEnergy {
  double net = 0, gross = 0;  // [J]
  double ratio() const { return gross > 0 ? net / gross : 0; }
};

// force() is called in order along the loop, so it may depend on the path, like a model that follows the HIP.
LoopEnergy loop_energy(const std::vector<Vec3>& loop, const std::function<Vec3(const Vec3&)>& force);

// The loop centre + a cos u + b sin u [m] at `points` values of u; the first is not repeated at the end.
std::vector<Vec3> ellipse(const Vec3& centre, const Vec3& a, const Vec3& b, std::size_t points);

}  // namespace forefeel
