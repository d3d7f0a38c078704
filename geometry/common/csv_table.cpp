#include "geometry/common/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

std::string content_of(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error) || std::filesystem::is_directory(file, error))
    throw InputError({.file = file.string()}, "cannot be read, expected a CSV file");
  const bool empty = std::filesystem::file_size(file, error) == 0 && !error;
  return empty ? std::string() : read_text_file(file);
}

// Place of each wanted column in the rows, in the order of `columns`.
struct Places {
  std::vector<std::size_t> number;
  std::size_t width = 0;  // of the header; 0 without one
};

// Finds the columns in the first row. If that row holds numbers, it is not a header; it is read again as data.
Places find_places(CsvRows& rows, std::span<const std::string_view> columns, const std::string& wanted) {
  Places places;
  double value = 0;
  if (parse_real(rows.cells().front(), value)) {
    for (std::size_t i = 0; i < columns.size(); ++i) places.number.push_back(i);
    rows.again();
    return places;
  }
  places.width = rows.cells().size();
  for (const std::string_view column : columns) {
    const auto found = std::ranges::find(rows.cells(), column);
    if (found == rows.cells().end())
      rows.fail(fmt::format("column {} is missing, expected a header {}", column, wanted));
    places.number.push_back(static_cast<std::size_t>(found - rows.cells().begin()));
  }
  return places;
}

}  // namespace

CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  bool whole_lines) {
  const std::string content = content_of(file), wanted = fmt::format("{}", fmt::join(columns, ","));
  CsvRows rows(content, file.string());
  if (whole_lines) rows.expect_whole_lines();
  CsvTable table{.columns = columns.size(), .values = {}, .lines = {}};
  if (!rows.next())
    throw InputError({.file = file.string()}, fmt::format("holds no rows, expected {}", wanted));
  const Places places = find_places(rows, columns, wanted);
  while (rows.next()) {
    const auto cells = rows.cells();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (places.number[i] >= cells.size())
        rows.fail(fmt::format("a row of {} values, expected {}", cells.size(), wanted));
      double value = 0;
      const std::string_view cell = cells[places.number[i]];
      if (!parse_real(cell, value) || !std::isfinite(value))
        rows.fail(fmt::format("{} is '{}', expected a finite number", columns[i], cell));
      table.values.push_back(value);
    }
    if (cells.size() < places.width)
      rows.fail(fmt::format("a row of {} values, expected {} as in the header: was the file cut short?",
                            cells.size(), places.width));
    table.lines.push_back(rows.line());
  }
  if (table.rows() == 0)
    throw InputError({.file = file.string()}, fmt::format("holds no rows, expected {}", wanted));
  return table;
}

}  // namespace forefeel
