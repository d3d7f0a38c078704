#pragma once
// The springs of a compliant pad (solver/body/pad.hpp) over local nodes, the tip included:
//   E_pad = 1/2 sum_ij M_ij w_i . w_j = 1/2 u^T M u,   w_i = u_i - x
// M [N/m] couples nodes, not components: each entry stands for M_ij I. The row of the tip is minus the sum of the
// others, so a shift of body and tip together costs nothing. Clamped nodes have u = 0 and no row.

#include <cstdint>
#include <vector>

#include "solver/kernels/kernels.hpp"

namespace forefeel {

struct PadSprings {
  // Entry a <= b of M, local nodes, and its block of Discretisation::pattern.
  struct Pair {
    std::int32_t a = 0, b = 0;
    std::int64_t block = 0;
    double stiffness = 0;
  };
  std::vector<Pair> pairs;

  double energy(const double* u) const;                      // [J]
  void apply(const double* u, double* y) const;              // y += M u, [N]
  void apply_lanes(const double* u, double* y) const;        // of eight fields side by side
  void energy_lanes(const double* u, double* energy) const;  // energy[8] +=
  void add_to(double* blocks) const;                         // blocks += M
};

}  // namespace forefeel
