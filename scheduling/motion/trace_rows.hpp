#pragma once
// The samples of a recorded motion (trace_file.hpp), as in its file.

#include <cstddef>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

// The samples of a file, in its order and unchanged: times may repeat or go back.
struct TraceRows {
  std::vector<double> times;       // the first is 0 [s]
  std::vector<Vec3> positions;     // [m]
  std::vector<std::size_t> lines;  // number of each row's line in the file, from 1
  std::size_t missing = 0;         // rows left out: position empty or not a number
  std::size_t lost = 0;            // rows at 0, 0, 0 far from their neighbours (trace_flaws.hpp)
  bool lost_left_out = false;      // true if the format gives columns, a rate, units or a tool
  std::size_t ignored = 0;         // columns that are not read
  bool times_unused = false;       // a column of times beside a rate
  bool orientation = false;        // some of the ignored columns look like an orientation
};

}  // namespace forefeel
