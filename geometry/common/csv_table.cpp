#include "geometry/common/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

bool parse(std::string_view cell, double& value) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size();
}

}  // namespace

CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  const CsvOptions& options) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file))
    throw InputError({.file = file.string()}, "cannot be read, expected a CSV file");
  const auto wanted = fmt::format("{}", fmt::join(columns, ","));
  std::vector<std::size_t> place;  // of each wanted column in the file
  std::size_t text_place = std::string_view::npos;
  CsvTable table{.columns = columns.size(), .values = {}, .texts = {}, .lines = {}};
  std::vector<std::string_view> cells;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    const auto content = trimmed(line);
    if (content.empty() || content.front() == '#') continue;
    const InputPlace where{.file = file.string(), .line = number};
    split(content, cells);
    if (place.empty()) {
      double value = 0;
      const bool headerless = parse(cells.front(), value) && options.text_column.empty();
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const auto found = std::find(cells.begin(), cells.end(), columns[i]);
        if (!headerless && found == cells.end())
          throw InputError(where,
                           fmt::format("column {} is missing, expected a header {}", columns[i], wanted));
        place.push_back(headerless ? i : static_cast<std::size_t>(found - cells.begin()));
      }
      if (!options.text_column.empty()) {
        const auto found = std::find(cells.begin(), cells.end(), options.text_column);
        if (found == cells.end())
          throw InputError(where, fmt::format("column {} is missing in the header", options.text_column));
        text_place = static_cast<std::size_t>(found - cells.begin());
      }
      if (!headerless) continue;
    }
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (place[i] >= cells.size())
        throw InputError(where, fmt::format("a row of {} values, expected {}", cells.size(), wanted));
      double value = std::numeric_limits<double>::quiet_NaN();
      const auto cell = cells[place[i]];
      if (!(cell.empty() && options.allow_empty_cells) && (!parse(cell, value) || !std::isfinite(value)))
        throw InputError(where, fmt::format("{} is '{}', expected a finite number", columns[i], cell));
      table.values.push_back(value);
    }
    if (text_place != std::string_view::npos)
      table.texts.emplace_back(text_place < cells.size() ? cells[text_place] : "");
    table.lines.push_back(number);
  }
  if (table.rows() == 0)
    throw InputError({.file = file.string()}, fmt::format("holds no rows, expected {}", wanted));
  return table;
}

}  // namespace forefeel
