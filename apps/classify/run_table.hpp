#pragma once
// A CSV file of a run with a header line: columns by name, numbers where a cell is one, text as it stands.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

class RunTable {
 public:
  // InputError names file and line for a missing file, no header, or a row of another length.
  static RunTable read(const std::filesystem::path& file);

  std::size_t rows() const { return columns_.empty() ? 0 : cells_.size() / columns_.size(); }
  bool has(std::string_view column) const { return index(column).has_value(); }
  std::string_view text(std::size_t row, std::string_view column) const;  // "" where the column is absent
  double number(std::size_t row, std::string_view column) const;  // NaN where absent, empty or no number
  std::vector<double> numbers(std::string_view column) const;     // #rows

 private:
  std::optional<std::size_t> index(std::string_view column) const;

  std::shared_ptr<const std::string> file_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;  // #rows x #columns, row by row, in *file_
};

}  // namespace forefeel
