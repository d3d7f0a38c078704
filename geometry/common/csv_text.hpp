#pragma once
// A CSV file with a header line, every cell kept as text: columns by name, numbers where a cell is one. For
// files in which cells may be empty or hold words; csv_table.hpp is for columns of numbers alone.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

class CsvText {
 public:
  // InputError that names file and line for a missing file, no header, a row of another length than the
  // header, or a last line without a line break (a file that was cut short). expected: what the message calls the file ("a file of a run").
  static CsvText read(const std::filesystem::path& file, std::string_view expected);

  std::size_t rows() const { return lines_.size(); }
  std::size_t line(std::size_t row) const { return lines_[row]; }  // in the file, from 1
  bool has(std::string_view column) const { return index(column).has_value(); }
  std::string_view text(std::size_t row, std::string_view column) const;  // "" where the column is absent
  double number(std::size_t row, std::string_view column) const;  // NaN where absent, empty or no number

 private:
  std::optional<std::size_t> index(std::string_view column) const;

  std::shared_ptr<const std::string> content_;  // what the cells are views of
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;  // #rows x #columns, row by row
  std::vector<std::size_t> lines_;       // #rows
};

}  // namespace forefeel
