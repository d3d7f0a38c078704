#pragma once
// Splits a table from any source into cells, for trace_file.hpp. Cells are separated by commas, semicolons, tabs or
// white space: the separator that yields the most numbers is used. Quotes around a cell are dropped. Blank lines are
// skipped, and so are lines that begin with #, unless they hold column names.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

using TraceCells = std::vector<std::string_view>;

struct TraceRow {
  std::size_t line = 0;  // in the file, from 1
  TraceCells cells;      // views into the content
  bool comment = false;  // behind #
};

std::vector<TraceRow> trace_rows_of(const std::string& content);
// A number with a decimal point, or with a decimal comma where commas do not separate cells.
bool trace_number(std::string_view cell, double& value);
bool trace_missing(std::string_view cell);           // empty, -, na, nan, null or missing
std::size_t trace_numbers(const TraceCells& cells);  // how many cells are numbers

}  // namespace forefeel
