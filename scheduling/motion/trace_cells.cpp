#include "scheduling/motion/trace_cells.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "geometry/common/scanner.hpp"

namespace forefeel {

namespace {

using Cells = TraceCells;
using Row = TraceRow;

constexpr std::string_view white = " \t\r";

std::string_view bare(std::string_view cell) {
  cell = trimmed(cell);
  const bool quoted = cell.size() >= 2 && cell.front() == '"' && cell.back() == '"';
  return quoted ? cell.substr(1, cell.size() - 2) : cell;
}

Cells split_at(std::string_view line, char separator) {
  Cells cells;
  if (separator != ' ') {
    for (std::size_t end; (end = line.find(separator)) != std::string_view::npos; line.remove_prefix(end + 1))
      cells.push_back(bare(line.substr(0, end)));
    cells.push_back(bare(line));
    return cells;
  }
  for (std::size_t begin; (begin = line.find_first_not_of(white)) != std::string_view::npos;) {
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(white), line.size());
    cells.push_back(bare(line.substr(0, end)));
    line.remove_prefix(end);
  }
  return cells;
}

std::vector<std::pair<std::size_t, std::string_view>> lines_of(std::string_view content) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (content.starts_with(byte_order_mark)) content.remove_prefix(byte_order_mark.size());
  std::vector<std::pair<std::size_t, std::string_view>> lines;
  for (std::size_t line = 1; !content.empty(); ++line) {
    const std::string_view text = content.substr(0, content.find('\n'));
    content.remove_prefix(std::min(content.size(), text.size() + 1));
    if (!trimmed(text).empty()) lines.emplace_back(line, text);
  }
  return lines;
}

// The separator that yields the most numbers on a sample of the lines; in a tie, the first one below.
char separator_of(const std::vector<std::pair<std::size_t, std::string_view>>& lines) {
  char best = ',';
  std::size_t most = 0;
  for (const char candidate : {',', '\t', ';', ' '}) {
    std::size_t numbers = 0;
    const std::size_t step = std::max<std::size_t>(1, lines.size() / 50);
    for (std::size_t i = 0; i < lines.size(); i += step)
      numbers += trace_numbers(split_at(lines[i].second, candidate));
    if (numbers > most) {
      most = numbers;
      best = candidate;
    }
  }
  return best;
}

}  // namespace

bool trace_number(std::string_view cell, double& value) {
  if (parse_real(cell, value)) return true;
  if (cell.find(',') == std::string_view::npos || cell.find('.') != std::string_view::npos) return false;
  std::string text(cell);
  std::ranges::replace(text, ',', '.');
  return parse_real(text, value);
}

bool trace_missing(std::string_view cell) {
  const std::string word = lower_case(cell);
  return word.empty() || word == "na" || word == "nan" || word == "null" || word == "missing" || word == "-";
}

std::size_t trace_numbers(const Cells& cells) {
  double value = 0;
  return static_cast<std::size_t>(
      std::ranges::count_if(cells, [&](std::string_view cell) { return trace_number(cell, value); }));
}

std::vector<Row> trace_rows_of(const std::string& content) {
  const auto lines = lines_of(content);
  const char separator = separator_of(lines);
  std::vector<Row> rows;
  for (const auto& [line, text] : lines) {
    Row row{.line = line, .cells = split_at(text, separator)};
    if (row.cells.front().starts_with('#')) {  // a comment, or a header behind the mark
      row.cells.front().remove_prefix(1);
      row.cells.front() = bare(row.cells.front());
      if (row.cells.front().empty()) row.cells.erase(row.cells.begin());
      if (row.cells.empty() || trace_numbers(row.cells) > 0) continue;
      row.comment = true;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

namespace {

constexpr std::size_t rows_searched = 200;

bool holds_data(const TraceCells& cells) {
  return trace_numbers(cells) >= 3 && 2 * trace_numbers(cells) > cells.size();
}

std::size_t names_in(const TraceCells& cells) {
  const auto filled = std::ranges::count_if(cells, [](std::string_view cell) { return !cell.empty(); });
  return static_cast<std::size_t>(filled) - trace_numbers(cells);
}

}  // namespace

std::size_t columns_called(const TraceCells& cells, std::string_view wanted) {
  return static_cast<std::size_t>(std::ranges::count(cells, wanted));
}

std::optional<std::size_t> column_called(const TraceCells& cells, std::string_view wanted) {
  const auto exact = columns_called(cells, wanted);
  if (exact > 1) return {};
  if (exact == 1) return std::ranges::find(cells, wanted) - cells.begin();
  const auto alike = [&](std::string_view cell) { return lower_case(cell) == lower_case(wanted); };
  const auto like = std::ranges::find_if(cells, alike);
  if (like != cells.end() && std::count_if(like, cells.end(), alike) == 1) return like - cells.begin();
  return {};
}

std::optional<std::size_t> column_number(const std::string& column) {
  std::int64_t number = 0;
  if (!parse_integer(column, number) || number < 0) return {};
  return static_cast<std::size_t>(number);
}

std::optional<std::size_t> headless_row(const std::vector<TraceRow>& rows, std::size_t n) {
  const std::size_t end = std::min(rows.size(), rows_searched);
  for (std::size_t row = 0; row < end; ++row) {
    const TraceCells& cells = rows[row].cells;
    const TraceCells first(cells.begin(),
                           cells.begin() + static_cast<std::ptrdiff_t>(std::min(n, cells.size())));
    if (trace_numbers(first) == n) {
      for (std::size_t before = 0; before < row; ++before)
        if (!rows[before].comment || rows[before].cells.size() == cells.size()) return {};
      return row;
    }
    if (!rows[row].comment) return {};
  }
  return {};
}

std::size_t likely_header(const std::vector<TraceRow>& rows, std::size_t end) {
  std::size_t header = 0;
  for (std::size_t row = 0; row < std::min(end, rows_searched); ++row) {
    // A single row of numbers may be part of a header, as in .trc files.
    if (holds_data(rows[row].cells) && (row + 1 == rows.size() || holds_data(rows[row + 1].cells))) break;
    if (names_in(rows[row].cells) > names_in(rows[header].cells)) header = row;
  }
  return header;
}

bool is_of_orientation(std::string_view title) {
  static constexpr std::array words{"q0",    "q1",   "q2",      "q3",        "q4",    "qw",     "qx",   "qy",
                                    "qz",    "q_rs", "rx",      "ry",        "rz",    "rot",    "roll", "yaw",
                                    "pitch", "quat", "azimuth", "elevation", "euler", "orient", "angle"};
  const std::string text = lower_case(title);
  return std::ranges::any_of(words, [&](const char* word) { return text.find(word) != std::string::npos; });
}

bool is_of_time(std::string_view title) {
  const std::string text = lower_case(title);
  return text == "t" || text.find("time") != std::string::npos;
}

bool is_of_tool(std::string_view title) {
  static constexpr std::array words{"tool",   "tool id", "tool_id", "toolid",    "tool name", "sensor",
                                    "marker", "device",  "station", "sensor_id", "sensorid",  "hand",
                                    "object", "body",    "arm",     "tracker"};
  return std::ranges::find(words, lower_case(title)) != words.end();
}

}  // namespace forefeel
