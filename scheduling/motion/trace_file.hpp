#pragma once
// Reads a recorded motion from a table of numbers, separated by commas, semicolons, tabs or white space, with or
// without a header. Additional columns are allowed. The file does not have to be edited.
//
//   columns   t, x, y and z: names of a header, or numbers of columns counted from 1. Lines before the header
//             and lines of units below it are skipped. A dash stands for a coordinate that the file lacks; it is
//             zero, like z of a pen on a tablet. Without `columns`: t,x,y,z (x,y,z with a rate).
//   rate      samples per second [Hz], for a file without a time column; every row is then a sample
//   unit      of the positions and of the time: m, cm, mm, s, ms, us, or one of each, as mm/ms
//   tool      selects one of several tools in a file: its name or number in the column of tool names. If each tool
//             has its own columns: the text before x, y and z in their names
//
// Recorded orientation is not read, because the HIP is a point. `ignored` counts the columns that were not read.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {

// What to do with a row whose position is empty or not a number, as when a marker is out of sight.
enum class MissingPositions { refuse, leave_out };

// The samples of a file, in its order and unchanged: times may repeat or go back.
struct TraceRows {
  std::vector<double> times;       // the first is 0 [s]
  std::vector<Vec3> positions;     // [m]
  std::vector<std::size_t> lines;  // number of each row's line in the file, from 1
  std::size_t missing = 0;         // rows left out: position empty or not a number
  std::size_t lost = 0;            // rows at 0, 0, 0 far from their neighbours (trace_check.hpp)
  bool lost_left_out = false;      // true if the format gives columns, a rate, units or a tool
  std::size_t ignored = 0;         // columns that are not read
  bool times_unused = false;       // a column of times beside a rate
  bool orientation = false;        // some of the ignored columns look like an orientation
};

// "mm", "ms", "mm/ms" … into format. Returns false for another word.
bool parse_trace_unit(const std::string& text, TraceFormat& format);
// InputError with file and line: a missing column, a time that is not a number, no rows, several tools
// of which none is chosen (the message lists them).
TraceRows read_trace_rows(const std::filesystem::path& file, const TraceFormat& format,
                          MissingPositions missing);

}  // namespace forefeel
