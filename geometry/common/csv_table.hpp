#pragma once
// Reads columns of numbers from a CSV file. A header line names the columns, in any order; columns that were
// not asked for are ignored. If the first row holds numbers, there is no header, and columns are read by position.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

struct CsvTable {
  std::size_t columns = 0;
  std::vector<double> values;      // #rows x columns, row by row
  std::vector<std::string> texts;  // #rows: cells of the text column, if one was asked for
  std::vector<std::size_t> lines;  // #rows: line in the file, from 1

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

struct CsvOptions {
  bool allow_empty_cells = false;     // true: an empty cell is NaN; false: an error
  std::string_view text_column = {};  // a column to be kept as text; the file then needs a header
  bool whole_lines = false;  // true: the last line must end with a line break too, as forefeel's own files do
};

// InputError that names file and line: missing file, no rows, missing column, a row shorter than
// the header, a cell that is not a finite number.
CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  const CsvOptions& options = {});

}  // namespace forefeel
