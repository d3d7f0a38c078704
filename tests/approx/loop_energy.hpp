#pragma once
// Energy that a force field f [N] generates or dissipates around a closed loop x_k [m], k = 0 … m, x_m = x_0:
//   net   = |sum_k 1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
//   gross = sum_k |1/2 (f_k + f_{k+1}) . (x_{k+1} - x_k)|      [J]
// For a conservative field net is 0 up to the quadrature error. The quadrature is exact for f = -K x with
// symmetric K and of order m^-2 or better otherwise (better than any power of m on a smooth loop in a smooth
// field). net / gross is the share of its work that a hand gains or loses in each turn.

#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel::test {

struct LoopEnergy {
  double net = 0, gross = 0;  // [J]
  double ratio() const { return gross > 0 ? net / gross : 0; }
};

// force() is called in order along the loop, so it may depend on the path, like a model that follows the HIP.
inline LoopEnergy loop_energy(const std::vector<Vec3>& loop, const std::function<Vec3(const Vec3&)>& force) {
  LoopEnergy energy;
  if (loop.size() < 2) return energy;
  Vec3 before = force(loop.front());
  for (std::size_t k = 1; k <= loop.size(); ++k) {
    const Vec3 &from = loop[k - 1], &to = loop[k % loop.size()];
    const Vec3 now = force(to);
    const double work = 0.5 * (before + now).dot(to - from);
    energy.net += work;
    energy.gross += std::abs(work);
    before = now;
  }
  energy.net = std::abs(energy.net);
  return energy;
}

// The loop centre + a cos u + b sin u [m] at `points` values of u; the first is not repeated at the end.
inline std::vector<Vec3> ellipse(const Vec3& centre, const Vec3& a, const Vec3& b, std::size_t points) {
  std::vector<Vec3> loop;
  for (std::size_t k = 0; k < points; ++k) {
    const double u = 2 * M_PI * static_cast<double>(k) / static_cast<double>(points);
    loop.emplace_back(centre + std::cos(u) * a + std::sin(u) * b);
  }
  return loop;
}

}  // namespace forefeel::test
