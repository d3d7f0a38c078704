#include "geometry/common/csv_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/common/scanner.hpp"

namespace forefeel {

namespace {

std::string_view without_quotes(std::string_view cell) {
  const bool quoted = cell.size() >= 2 && cell.front() == '"' && cell.back() == '"';
  return quoted ? cell.substr(1, cell.size() - 2) : cell;
}

// The quote that ends the cell which begins with the one at `open`; a doubled quote inside is none.
std::size_t closing_quote(std::string_view text, std::size_t open) {
  std::size_t quote = open;
  do quote = text.find('"', quote + 1);
  while (quote < text.size() && quote + 1 < text.size() && text[quote + 1] == '"' && ++quote);
  return quote;
}

// Cuts the row with which `text` begins; returns its length. A cell in quotes may hold commas and line breaks.
std::size_t split(std::string_view text, std::vector<std::string_view>& cells) {
  cells.clear();
  std::size_t at = 0, end = std::min(text.find('\n'), text.size());
  for (;;) {
    const std::string_view left = text.substr(at, end - at);
    std::size_t length = std::min(left.find(','), left.size());
    const std::size_t first = left.find_first_not_of(" \t");
    if (first < length && left[first] == '"')
      if (const std::size_t quote = closing_quote(text, at + first); quote != std::string_view::npos) {
        if (quote > end) end = std::min(text.find('\n', quote), text.size());
        length = std::min(text.substr(0, end).find(',', quote), end) - at;
      }
    cells.push_back(without_quotes(trimmed(text.substr(at, length))));
    at += length + 1;
    if (at > end) return end;
  }
}

}  // namespace

CsvRows::CsvRows(const std::string& content, std::string name) : name_(std::move(name)), left_(content) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (left_.starts_with(byte_order_mark)) left_.remove_prefix(byte_order_mark.size());
}

void CsvRows::expect_whole_lines() const {
  if (left_.empty() || left_.back() == '\n') return;
  const auto lines = static_cast<std::size_t>(std::ranges::count(left_, '\n'));
  throw InputError({.file = name_, .line = next_line_ + lines},
                   "the file ends within this line, expected a whole file: it was cut short");
}

bool CsvRows::next() {
  if (std::exchange(again_, false)) return true;
  while (!left_.empty()) {
    std::string_view row = left_.substr(0, left_.find('\n'));
    const std::string_view text = trimmed(row);
    const bool skip = text.empty() || text.front() == '#';
    if (!skip) row = left_.substr(0, split(left_, cells_));
    left_.remove_prefix(std::min(left_.size(), row.size() + 1));
    line_ = next_line_;
    next_line_ += 1 + static_cast<std::size_t>(std::ranges::count(row, '\n'));
    if (!skip) return true;
  }
  return false;
}

std::size_t CsvRows::most_rows() const {
  return (again_ ? 2 : 1) + static_cast<std::size_t>(std::ranges::count(left_, '\n'));
}

std::vector<CsvRows> CsvRows::parts(std::size_t bytes) const {
  std::vector<CsvRows> found{*this};
  if (left_.size() <= bytes || left_.find('"') != std::string_view::npos) return found;
  for (;;) {
    std::string_view& left = found.back().left_;
    const std::size_t end = left.size() > bytes ? left.find('\n', bytes) : std::string_view::npos;
    if (end == std::string_view::npos) return found;
    const std::string_view rest = left.substr(end + 1);
    left = left.substr(0, end + 1);
    const std::size_t line =
        found.back().next_line_ + static_cast<std::size_t>(std::ranges::count(left, '\n'));
    found.push_back(*this);
    found.back().left_ = rest;
    found.back().next_line_ = line;
    found.back().again_ = false;
  }
}

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
