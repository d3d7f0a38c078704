#pragma once
// Reads a CSV file with a header line and keeps every cell as text. Columns are found by name; a cell is
// converted to a number on request. For files whose cells may be empty or hold words; csv_table.hpp is for
// columns of numbers only.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

class CsvText {
 public:
  // InputError that names file and line: the file or its header is missing, a row differs from the header in
  // length, or the last line has no line break (the file was cut short). expected: what the message calls the
  // file ("a file of a run").
  static CsvText read(const std::filesystem::path& file, std::string_view expected);

  std::size_t rows() const { return lines_.size(); }
  std::size_t line(std::size_t row) const { return lines_[row]; }  // in the file, from 1
  bool has(std::string_view column) const { return index(column).has_value(); }
  std::string_view text(std::size_t row, std::string_view column) const;  // "" where the column is absent
  double number(std::size_t row, std::string_view column) const;  // NaN if absent, empty or not a number

 private:
  std::optional<std::size_t> index(std::string_view column) const;

  std::shared_ptr<const std::string> content_;  // what the cells are views of
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;  // #rows x #columns, row by row
  std::vector<std::size_t> lines_;       // #rows
};

}  // namespace forefeel
