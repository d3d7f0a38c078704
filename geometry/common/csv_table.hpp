#pragma once
// Numeric columns of a CSV file with line numbers for messages. A header line names the columns (others are
// ignored); a file that starts with numbers is read by position.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

struct CsvTable {
  std::size_t columns = 0;
  std::vector<double> values;      // #rows x columns, row by row
  std::vector<std::string> texts;  // #rows, of the text column where one was asked for
  std::vector<std::size_t> lines;  // line of each row in the file, from 1

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

struct CsvOptions {
  bool allow_empty_cells = false;     // an empty cell reads as NaN; else it is an error
  std::string_view text_column = {};  // also kept as text; needs a header
};

// InputError(file:line) for a missing file, no rows, short rows, and anything that is not a finite number.
CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  const CsvOptions& options = {});

}  // namespace forefeel
