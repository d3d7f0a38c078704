#include "scheduling/motion/trace_stack.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "geometry/common/scanner.hpp"
#include "scheduling/motion/trace_header.hpp"

namespace forefeel {
namespace {

constexpr std::size_t rows_read = 40, rows_above = 8;

// "X", "x" and "X1" are x.
bool is_called(std::string_view cell, const std::string& wanted) {
  const std::string name = lower_case(cell), want = lower_case(wanted);
  return name.starts_with(want) && std::all_of(name.begin() + std::ssize(want), name.end(),
                                               [](char c) { return c >= '0' && c <= '9'; });
}

bool is_time(std::string_view cell, const std::string& wanted) {
  const std::string name = lower_case(cell);
  return name == lower_case(wanted) || (wanted == "t" && name.starts_with("time"));
}

class Stack {
 public:
  Stack(const std::vector<TraceRow>& rows, std::size_t axes) : rows_(rows), axes_(axes) {}

  std::size_t top() const { return axes_ - std::min(axes_, rows_above); }
  const TraceCells& cells(std::size_t row) const { return rows_[row].cells; }
  std::string_view cell(std::size_t row, std::size_t column) const {
    return column < cells(row).size() ? cells(row)[column] : std::string_view();
  }

  // Whether a row above says that this column belongs to an orientation.
  bool turned(std::size_t column) const {
    for (std::size_t row = top(); row < axes_; ++row)
      if (is_of_orientation(cell(row, column))) return true;
    return false;
  }

  std::vector<std::size_t> columns(const std::string& wanted) const {
    std::vector<std::size_t> found;
    for (std::size_t column = 0; column < cells(axes_).size(); ++column)
      if (is_called(cell(axes_, column), wanted) && !turned(column)) found.push_back(column);
    return found;
  }

  std::optional<std::size_t> time(const std::string& wanted) const {
    for (std::size_t row = axes_ + 1; row-- > top();)
      for (std::size_t column = 0; column < cells(row).size(); ++column)
        if (is_time(cell(row, column), wanted)) return column;
    return {};
  }

  // The columns of a tool: from its name to the next name in that row above; in the row of axes itself, to the end.
  std::optional<std::pair<std::size_t, std::size_t>> range(const std::string& tool) const {
    for (std::size_t row = axes_ + 1; row-- > top();) {
      const auto first = std::ranges::find(cells(row), tool) - cells(row).begin();
      if (first == std::ssize(cells(row))) continue;
      auto end = static_cast<std::size_t>(first) + 1;
      const std::size_t width = cells(axes_).size();
      while (end < width && (row == axes_ || cell(row, end).empty() || cell(row, end) == tool)) ++end;
      return std::pair(static_cast<std::size_t>(first), end);
    }
    return {};
  }

 private:
  const std::vector<TraceRow>& rows_;
  std::size_t axes_;
};

std::optional<StackedColumns> columns_below(const std::vector<TraceRow>& rows, std::size_t axes,
                                            const std::vector<std::string>& wanted, bool timed,
                                            const std::string& tool) {
  const Stack stack(rows, axes);
  StackedColumns found{.at = {}, .header = axes};
  const auto range =
      tool.empty() ? std::optional(std::pair(std::size_t{0}, stack.cells(axes).size())) : stack.range(tool);
  if (!range) return {};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (timed && i == 0) {
      const auto time = stack.time(wanted[0]);
      if (!time) return {};
      found.at.push_back(*time);
      continue;
    }
    std::vector<std::size_t> columns = stack.columns(wanted[i]);
    std::erase_if(columns, [&](std::size_t c) { return c < range->first || c >= range->second; });
    if (columns.empty() || (tool.empty() && columns.size() > 1)) return {};
    found.at.push_back(columns.front());
  }
  return found;
}

}  // namespace

std::optional<StackedColumns> stacked_columns(const std::vector<TraceRow>& rows,
                                              const std::vector<std::string>& wanted, bool timed,
                                              const std::string& tool) {
  for (std::size_t row = 0; row < std::min(rows.size(), rows_read); ++row)
    if (auto found = columns_below(rows, row, wanted, timed, tool)) return found;
  return {};
}

std::vector<std::string> stacked_tools(const std::vector<TraceRow>& rows, const std::string& x) {
  for (std::size_t axes = 0; axes < std::min(rows.size(), rows_read); ++axes) {
    const Stack stack(rows, axes);
    const std::vector<std::size_t> columns = stack.columns(x);
    if (columns.size() < 2) continue;
    std::vector<std::string> nearest;  // row of names, unless one is titled so
    for (std::size_t row = axes; row-- > stack.top();) {
      std::set<std::string> names;
      for (const std::size_t column : columns)
        if (!stack.cell(row, column).empty()) names.emplace(stack.cell(row, column));
      if (names.size() < 2) continue;
      const bool titled = std::ranges::any_of(
          stack.cells(row), [](std::string_view cell) { return lower_case(cell) == "name"; });
      if (titled || nearest.empty()) nearest = {names.begin(), names.end()};
      if (titled) break;
    }
    if (!nearest.empty()) return nearest;
  }
  return {};
}

}  // namespace forefeel
