#pragma once
// Loops over all states as seen from the HIP, compiled for several instruction sets (instruction_set.hpp).
// n is a multiple of 8; x, y, z: directions u_i to the states, shorter than 1 for states close to the HIP.

#include <cstddef>

namespace forefeel::view {

struct Loops {
  // Apparent distances along the direction v: seen[i] = |x_i - x| + scale max(0, cosine - u_i . v)^2;
  // *nearest is the least of them. distance[i] = |x_i - x|, ascending. Writes only as many as it returns: all
  // others exceed *nearest by more than `depth`.
  std::size_t (*seen)(std::size_t n, const double* x, const double* y, const double* z,
                      const double* distance, const double v[3], double cosine, double scale, double depth,
                      double* seen, double* nearest);
  // out = sum_i max(0, 1 - (seen[i] - nearest) / depth)^2 u_i
  void (*towards)(std::size_t n, const double* x, const double* y, const double* z, const double* seen,
                  double nearest, double depth, double out[3]);
};

const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::view
