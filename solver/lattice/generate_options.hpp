#pragma once
// What is generated of a lattice, and what came of it.

#include <cstddef>
#include <stop_token>

#include "geometry/common/types.hpp"

namespace forefeel {

struct GenerateOptions {
  double spacing = 0.006;
  Box box;
  int threads = 0;          // 0: all
  double tolerance = 1e-6;  // force, relative
  bool want_displacements = false;
  std::stop_token stop;
};
struct GenerateReport {
  std::size_t solved = 0, failed = 0, resumed = 0;
  std::size_t inverted = 0;  // of the solved: with inverted elements (state_outcome.hpp)
  double seconds = 0;
  int threads = 0;
};

}  // namespace forefeel
