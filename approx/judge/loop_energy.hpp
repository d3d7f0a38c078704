#pragma once
// Energy that a force field gives away around a closed loop x_0, x_1, …, x_m = x_0:
//   net   = |sum_k 1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
//   gross = sum_k |1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
// A conservative field has net 0 up to the quadrature, which is exact for f = -K x with symmetric K and of
// order m^-2 or better otherwise (better than any power on a smooth loop in a smooth field). net / gross is
// what a hand gains or loses with each turn of all the work it does.

#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct LoopEnergy {
  double net = 0, gross = 0;  // [J]
  double ratio() const { return gross > 0 ? net / gross : 0; }
};

// The field is asked in order along the loop, so that it may follow it as a HIP would.
LoopEnergy loop_energy(const std::vector<Vec3>& loop, const std::function<Vec3(const Vec3&)>& force);

// Closed loops: centre + a cos u + b sin u, `points` of them, the first not repeated at the end.
std::vector<Vec3> ellipse(const Vec3& centre, const Vec3& a, const Vec3& b, std::size_t points);

}  // namespace forefeel
