#include "geometry/common/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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
  std::optional<std::size_t> text;
  std::size_t width = 0;  // of the header; 0 without one
};

std::size_t place_of(const CsvRows& header, std::string_view column, const std::string& problem) {
  const auto found = std::ranges::find(header.cells(), column);
  if (found == header.cells().end()) header.fail(problem);
  return static_cast<std::size_t>(found - header.cells().begin());
}

// Finds the columns in the first row. If that row holds numbers, it is not a header; it is read again as data.
Places find_places(CsvRows& rows, std::span<const std::string_view> columns, const CsvOptions& options,
                   const std::string& wanted) {
  Places places;
  double value = 0;
  if (parse_real(rows.cells().front(), value) && options.text_column.empty()) {
    for (std::size_t i = 0; i < columns.size(); ++i) places.number.push_back(i);
    rows.again();
    return places;
  }
  places.width = rows.cells().size();
  for (const std::string_view column : columns)
    places.number.push_back(
        place_of(rows, column, fmt::format("column {} is missing, expected a header {}", column, wanted)));
  if (!options.text_column.empty())
    places.text = place_of(rows, options.text_column,
                           fmt::format("column {} is missing in the header", options.text_column));
  return places;
}

}  // namespace

CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  const CsvOptions& options) {
  const std::string content = content_of(file), wanted = fmt::format("{}", fmt::join(columns, ","));
  CsvRows rows(content, file.string());
  if (options.whole_lines) rows.expect_whole_lines();
  CsvTable table{.columns = columns.size(), .values = {}, .texts = {}, .lines = {}};
  if (!rows.next())
    throw InputError({.file = file.string()}, fmt::format("holds no rows, expected {}", wanted));
  const Places places = find_places(rows, columns, options, wanted);
  while (rows.next()) {
    const auto cells = rows.cells();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (places.number[i] >= cells.size())
        rows.fail(fmt::format("a row of {} values, expected {}", cells.size(), wanted));
      double value = std::numeric_limits<double>::quiet_NaN();
      const std::string_view cell = cells[places.number[i]];
      const bool may_be_empty = cell.empty() && options.allow_empty_cells;
      if (!may_be_empty && (!parse_real(cell, value) || !std::isfinite(value)))
        rows.fail(fmt::format("{} is '{}', expected a finite number", columns[i], cell));
      table.values.push_back(value);
    }
    if (cells.size() < places.width)
      rows.fail(fmt::format("a row of {} values, expected {} as in the header: was the file cut short?",
                            cells.size(), places.width));
    if (places.text) table.texts.emplace_back(*places.text < cells.size() ? cells[*places.text] : "");
    table.lines.push_back(rows.line());
  }
  if (table.rows() == 0)
    throw InputError({.file = file.string()}, fmt::format("holds no rows, expected {}", wanted));
  return table;
}

}  // namespace forefeel
