#pragma once
// Options and report of generate_lattice() (generate.hpp).

#include <cstddef>
#include <stop_token>

#include "geometry/common/types.hpp"

namespace forefeel {

struct GenerateOptions {
  double spacing = 0.006;   // h [m]
  Box box;                  // [m]
  int threads = 0;          // 0: all
  double tolerance = 1e-6;  // force, relative
  bool want_displacements = false;
  std::stop_token stop;
};
struct GenerateReport {
  std::size_t solved = 0, failed = 0, resumed = 0;
  std::size_t inverted = 0;  // of the solved: with inverted elements (state_outcome.hpp)
  double seconds = 0;        // wall time [s]
  int threads = 0;
};

}  // namespace forefeel
