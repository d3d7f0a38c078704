#pragma once
// Splits a table from any source into cells, for trace_file.hpp. Cells are separated by commas, semicolons, tabs or
// white space: the separator that yields the most numbers is used. Quotes around a cell are dropped. Blank lines are
// skipped, and so are lines that begin with #, unless they hold column names.

#include <cstddef>
#include <optional>
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

// Finds the names of columns in a table of unknown origin (trace_file.hpp).

// The column of this name, else the one column whose name differs only in case. Unset if several have the name.
std::optional<std::size_t> column_called(const TraceCells& cells, std::string_view wanted);
// How many columns have exactly this name.
std::size_t columns_called(const TraceCells& cells, std::string_view wanted);
// A column by its number from 1, or 0; unset for a name.
std::optional<std::size_t> column_number(const std::string& column);

// The first row whose first n cells are numbers, for a table without a header. Unset if a row of as many names, or text
// other than comments, precedes it.
std::optional<std::size_t> headless_row(const std::vector<TraceRow>& rows, std::size_t n);
// The row before `end` that is most likely a header: the one with most names before rows of numbers.
std::size_t likely_header(const std::vector<TraceRow>& rows, std::size_t end);

// Whether the title of a column names an orientation, times, or a tool.
bool is_of_orientation(std::string_view title);
bool is_of_time(std::string_view title);
bool is_of_tool(std::string_view title);

// Where in a table of numbers the samples of a recorded motion are. trace_file.hpp reads such a table.

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
