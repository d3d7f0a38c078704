#pragma once
// Reads columns of numbers from a CSV file. A header line names the columns, in any order; columns that were
// not asked for are ignored. If the first row holds numbers, there is no header, and columns are read by position.

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace forefeel {

struct CsvTable {
  std::size_t columns = 0;
  std::vector<double> values;      // #rows x columns, row by row
  std::vector<std::size_t> lines;  // #rows: line in the file, from 1

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

// InputError that names file and line: missing file, no rows, missing column, a row shorter than
// the header, a cell that is not a finite number. whole_lines: also for a last line without a line break; forefeel's
// own files end with one.
CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  bool whole_lines = false);

}  // namespace forefeel
