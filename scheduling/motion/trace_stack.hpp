#pragma once
// Reads tables whose header also names markers or tools. The names are in a row above the columns x, y and z, as in
// .trc files (RASI above X1 Y1 Z1) and exports of Motive (a row of names, then one of Rotation and Position). Or they
// are in the same row in front of x, y and z, as in files of NDI (Port 1, Frame, …, Tx, Ty, Tz, Port 2, …).

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {

struct StackedColumns {
  std::vector<std::size_t> at;  // of each wanted column
  std::size_t header = 0;       // the row that names x, y and z
};

// wanted: (t,) x, y, z. A name matches a column of the same name, also with a number behind it (X1); case is ignored.
// t also matches "Time", and may be in a row above. Columns below a word of orientation are ignored. tool: a name above
// or in front of the columns; empty if only one tool has such columns. Unset if there are none.
std::optional<StackedColumns> stacked_columns(const std::vector<TraceRow>& rows,
                                              const std::vector<std::string>& wanted, bool timed,
                                              const std::string& tool);
// The names above the columns x of such a table; empty if it has at most one.
std::vector<std::string> stacked_tools(const std::vector<TraceRow>& rows, const std::string& x);

}  // namespace forefeel
