#pragma once
// A motion as people have recorded it: a table of numbers, separated by commas, semicolons, tabs or white
// space, with or without a header, with more columns than are needed. Nothing in the file has to be edited.
//
//   columns   t, x, y and z: names of a header, or numbers of columns counted from 1. Lines before the header
//             and lines of units below it are skipped. A dash stands for a coordinate that the file does
//             not have and that is zero, as the third one of a pen. Without `columns`: t,x,y,z (x,y,z with a rate).
//   rate      samples in a second [Hz], for a file without a time column; every row then is a sample
//   unit      of the positions and of the time: m, cm, mm, s, ms, us, or one of each, as mm/ms
//   tool      one of several tools in a file: the name or number in the column of names, or, where each tool
//             has columns of its own, what comes before x, y and z in their names
//
// Recorded orientation is not read, as the HIP is a point; `ignored` says how many columns were not.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "scheduling/motion/trace_rows.hpp"

namespace forefeel {

struct TraceFormat {
  std::vector<std::string> columns = {};  // t,x,y,z, or x,y,z with a rate; empty: by these names
  double rate = 0;                        // [Hz]; 0: times are in a column
  double metre = 1;                       // length of the unit of positions [m]
  double second = 1;                      // length of the unit of time [s]
  std::string tool = {};                  // empty: the file holds one

  // Whether nothing is said: CSV t,x,y,z in SI units.
  bool is_usual() const { return columns.empty() && rate == 0 && metre == 1 && second == 1 && tool.empty(); }
};

// A row whose position is empty or not a number, as where a marker is out of sight.
enum class MissingPositions { refuse, leave_out };

// "mm", "ms", "mm/ms" … into format. Returns false for another word.
bool parse_trace_unit(const std::string& text, TraceFormat& format);
// InputError with file and line: a column that is missing, a time that is no number, no rows, several tools
// of which none is chosen (the message lists them).
TraceRows read_trace_rows(const std::filesystem::path& file, const TraceFormat& format,
                          MissingPositions missing);

}  // namespace forefeel
