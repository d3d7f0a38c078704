#pragma once
// The cells of a table that anybody has written, for trace_file.hpp. Cells are separated by commas, semicolons,
// tabs or white space, whichever gives most numbers. Quotes around a cell are dropped, as are blank lines, and
// lines behind # unless they hold names.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

using TraceCells = std::vector<std::string_view>;

struct TraceRow {
  std::size_t line = 0;  // in the file, from 1
  TraceCells cells;      // views into the content
};

std::vector<TraceRow> trace_rows_of(const std::string& content);
// A number with a decimal point, or with a decimal comma where commas do not separate cells.
bool trace_number(std::string_view cell, double& value);
std::size_t trace_numbers(const TraceCells& cells);  // how many cells are numbers

}  // namespace forefeel
