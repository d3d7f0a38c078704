#pragma once
// Where in a table of numbers the samples of a recorded motion are. trace_file.hpp reads such a table.

#include <string>
#include <vector>

namespace forefeel {

struct TraceFormat {
  std::vector<std::string> columns = {};  // t,x,y,z, or x,y,z with a rate; empty: by these names
  double rate = 0;                        // [Hz]; 0: times are in a column
  double metre = 1;                       // length of the unit of positions [m]
  double second = 1;                      // length of the unit of time [s]
  std::string tool = {};                  // empty: the file holds one

  // True if everything has its default: CSV t,x,y,z in SI units.
  bool is_usual() const { return columns.empty() && rate == 0 && metre == 1 && second == 1 && tool.empty(); }
};

}  // namespace forefeel
