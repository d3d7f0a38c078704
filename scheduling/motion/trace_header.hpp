#pragma once
// Finds the names of columns in a table of unknown origin (trace_file.hpp).

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scheduling/motion/trace_cells.hpp"

namespace forefeel {

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

}  // namespace forefeel
