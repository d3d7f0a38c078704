#include "scheduling/motion/trace_header.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "geometry/common/scanner.hpp"

namespace forefeel {
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
