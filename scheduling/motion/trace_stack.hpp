#pragma once
// Tables whose header has several rows: the names of markers or tools stand above the columns x, y and z, as in .trc
// files (RASI above X1 Y1 Z1), in exports of Motive (a row of names, one of Rotation and Position), or in front of them
// in the same row, as in files of NDI (Port 1, Frame, …, Tx, Ty, Tz, Port 2, …).

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

// wanted: (t,) x, y, z. A name matches a column of the same name, or with a number behind it (X1), case ignored; a time
// also "Time" where t was wanted, and it may stand in a row above. Columns below a word of orientation are left out.
// tool: a name above or in front of the columns; empty: only where one tool has such columns. Unset if there are none.
std::optional<StackedColumns> stacked_columns(const std::vector<TraceRow>& rows,
                                              const std::vector<std::string>& wanted, bool timed,
                                              const std::string& tool);
// The names that stand above the columns x of such a table; empty if it has at most one.
std::vector<std::string> stacked_tools(const std::vector<TraceRow>& rows, const std::string& x);

}  // namespace forefeel
