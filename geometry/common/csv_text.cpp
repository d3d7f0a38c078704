#include "geometry/common/csv_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/scanner.hpp"

namespace forefeel {

CsvText CsvText::read(const std::filesystem::path& file, std::string_view expected) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw InputError({.file = file.string()}, fmt::format("cannot be read, expected {}", expected));
  if (std::filesystem::file_size(file, error) == 0 && !error)
    throw InputError({.file = file.string()}, "is empty, expected a header line");
  CsvText table;
  table.content_ = std::make_shared<const std::string>(read_text_file(file));
  CsvRows rows(*table.content_, file.string());
  rows.expect_whole_lines();
  if (!rows.next()) throw InputError({.file = file.string()}, "is empty, expected a header line");
  table.columns_.assign(rows.cells().begin(), rows.cells().end());
  while (rows.next()) {
    if (rows.cells().size() != table.columns_.size())
      rows.fail(fmt::format("has {} cells, expected {}", rows.cells().size(), table.columns_.size()));
    table.cells_.insert(table.cells_.end(), rows.cells().begin(), rows.cells().end());
    table.lines_.push_back(rows.line());
  }
  return table;
}

std::optional<std::size_t> CsvText::index(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) return {};
  return static_cast<std::size_t>(found - columns_.begin());
}

std::string_view CsvText::text(std::size_t row, std::string_view column) const {
  const std::optional<std::size_t> at = index(column);
  return at ? cells_[row * columns_.size() + *at] : std::string_view();
}

double CsvText::number(std::size_t row, std::string_view column) const {
  double value = 0;
  return parse_real(text(row, column), value) ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace forefeel
