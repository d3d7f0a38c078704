#include "scheduling/motion/trace_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "scheduling/motion/trace_cells.hpp"
#include "scheduling/motion/trace_check.hpp"

namespace forefeel {
namespace {

constexpr std::size_t nowhere = static_cast<std::size_t>(-1);  // place of a column that the file lacks: "-"
constexpr double absent = std::numeric_limits<double>::quiet_NaN();
using Cells = TraceCells;
using Row = TraceRow;

// Where the wanted columns are, and where the data begin.
struct Layout {
  std::vector<std::size_t> at;        // of each wanted column
  std::optional<std::size_t> header;  // row of names
  std::optional<std::size_t> names;   // column that names the tool
  std::size_t first = 0;              // row of data
};

class Reader {
 public:
  Reader(const std::filesystem::path& file, const TraceFormat& format, MissingPositions missing)
      : name_(file.string()),
        format_(format),
        missing_(missing),
        content_(read_text_file(file)),
        rows_(trace_rows_of(content_)) {
    if (content_.find('\0') != std::string::npos)
      throw InputError({.file = name_}, "is no text, expected a table of numbers");
    if (rows_.empty()) throw InputError({.file = name_}, "holds no rows, expected t,x,y,z");
  }

  TraceRows read() {
    const std::vector<std::string> wanted = wanted_columns();
    find(wanted);
    skip_to_data();
    choose_tool();
    if (are_matrices(rows_, layout_.first))
      throw InputError({.file = name_, .line = rows_[layout_.first].line},
                       "four lines make one 4 x 4 matrix, expected the numbers of a sample in one line");
    TraceRows out = take();
    const std::vector<std::size_t> lost = lost_rows(out);
    out.lost = lost.size();
    out.lost_left_out = !format_.is_usual();
    if (out.lost_left_out) leave_out(out, lost);
    return out;
  }

 private:
  bool timed() const { return format_.rate == 0; }

  std::vector<std::string> wanted_columns() const {
    const std::size_t n = timed() ? 4 : 3;
    if (!format_.columns.empty()) {
      if (format_.columns.size() != n)
        throw InputError({.file = name_},
                         fmt::format("columns names {} columns, expected {}", format_.columns.size(),
                                     timed() ? "t/x/y/z" : "x/y/z beside a rate"));
      return format_.columns;
    }
    return timed() ? std::vector<std::string>{"t", "x", "y", "z"} : std::vector<std::string>{"x", "y", "z"};
  }

  // The columns of a tool that has its own: "left" has left_x, left.y, "left z" …
  std::optional<std::size_t> own_column(const Cells& cells, const std::string& axis) const {
    for (const std::string_view between : {"", "_", ".", "-", " ", "/", ":", "_pos_", "_POS_"})
      if (const auto at = column_called(cells, fmt::format("{}{}{}", format_.tool, between, axis))) return at;
    return {};
  }

  bool find_in_header(std::size_t row, const std::vector<std::string>& wanted, bool own) {
    std::vector<std::size_t> at;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const bool is_time = timed() && i == 0;
      auto found = column_called(rows_[row].cells, wanted[i]);
      if (own && !is_time) found = own_column(rows_[row].cells, wanted[i]);
      if (wanted[i] == "-" && !is_time) found = nowhere;
      if (!found)
        if (const auto number = column_number(wanted[i]); number && *number > 0) found = *number - 1;
      if (!found) return false;
      at.push_back(*found);
    }
    layout_.at = std::move(at);
    layout_.header = row;
    layout_.first = row + 1;
    own_columns_ = own;
    return true;
  }

  // The first rows are searched for names. A row of numbers is no header.
  void find(const std::vector<std::string>& wanted) {
    const bool by_number = !format_.columns.empty() && std::ranges::all_of(wanted, [](const auto& c) {
      return c == "-" || column_number(c).has_value();
    });
    if (by_number) return find_numbered(wanted);
    for (std::size_t row = 0; row < std::min<std::size_t>(rows_.size(), 200); ++row)
      if (find_in_header(row, wanted, false) || (!format_.tool.empty() && find_in_header(row, wanted, true)))
        return;
    if (const auto row = headless_row(rows_, wanted.size()); row && format_.columns.empty()) {
      for (std::size_t i = 0; i < wanted.size(); ++i) layout_.at.push_back(i);
      layout_.first = *row;
      return;
    }
    fail_without(wanted);
  }

  [[noreturn]] void fail_without(const std::vector<std::string>& wanted) const {
    const std::size_t header = likely_header(rows_, rows_.size());
    const Cells& cells = rows_[header].cells;
    std::string missing;
    for (std::size_t i = wanted.size(); i-- > 0;)
      if (!column_called(cells, wanted[i]) && !column_number(wanted[i])) missing = wanted[i];
    if (const std::size_t same = columns_called(cells, missing); same > 1)
      throw InputError(
          {.file = name_, .line = rows_[header].line},
          fmt::format("{} columns are called '{}', expected their numbers from 1", same, missing));
    const Cells some(cells.begin(), cells.begin() + std::min<std::ptrdiff_t>(std::ssize(cells), 24));
    throw InputError(
        {.file = name_, .line = rows_[header].line},
        fmt::format("there is no column '{}', expected columns={} by names of the header ({}{}) or "
                    "by numbers from 1",
                    missing, timed() ? "t/x/y/z" : "x/y/z", fmt::join(some, ", "),
                    cells.size() > 24 ? ", …" : ""));
  }

  void find_numbered(const std::vector<std::string>& wanted) {
    std::size_t width = 0;
    for (const Row& row : rows_) width = std::max(width, row.cells.size());
    for (const std::string& column : wanted) {
      if (column == "-") {
        if (timed() && layout_.at.empty())
          throw InputError({.file = name_}, "columns has no time, expected one or a rate");
        layout_.at.push_back(nowhere);
        continue;
      }
      const std::size_t number = *column_number(column);
      if (number < 1 || number > width)
        throw InputError({.file = name_},
                         fmt::format("has no column {}, expected a number from 1 to {}", column, width));
      layout_.at.push_back(number - 1);
    }
  }

  bool all_numbers(const Row& row) const {
    double value = 0;
    return std::ranges::all_of(layout_.at, [&](std::size_t at) {
      return at == nowhere || (at < row.cells.size() && trace_number(row.cells[at], value));
    });
  }

  // In the unit of the file.
  std::optional<double> time_in(const Row& row) const {
    double time = 0;
    if (layout_.at[0] < row.cells.size() && trace_number(row.cells[layout_.at[0]], time)) return time;
    return {};
  }

  [[noreturn]] void fail_without_numbers() const {
    const Row& row = rows_[layout_.first];
    std::vector<std::string> cells;
    for (const std::size_t at : layout_.at)
      if (at != nowhere)
        cells.push_back(fmt::format("'{:.40}'", at < row.cells.size() ? row.cells[at] : std::string_view()));
    throw InputError(
        {.file = name_, .line = row.line},
        fmt::format("no row has a number in each of the columns {}, which hold {} here, expected some{}",
                    fmt::join(wanted_columns(), ", "), fmt::join(cells, ", "),
                    timed() ? "; a time is a number, not a date" : ""));
  }

  // Skips further rows before the data, such as names and units.
  void skip_to_data() {
    std::size_t row = layout_.first;
    if (row == rows_.size())
      throw InputError({.file = name_}, "holds no rows below its header, expected some");
    if (missing_ == MissingPositions::refuse) return;
    while (row < rows_.size() && !all_numbers(rows_[row])) ++row;
    if (row == rows_.size()) fail_without_numbers();
    // Rows without a position also count as samples; rows without a time do not.
    while (row > layout_.first && timed() && time_in(rows_[row - 1])) --row;
    if (!layout_.header && row > 0) layout_.header = likely_header(rows_, row);
    layout_.first = row;
  }

  std::map<std::string_view, std::size_t> values_in(std::size_t column, std::size_t most) const {
    std::map<std::string_view, std::size_t> values;
    for (std::size_t row = layout_.first; row < rows_.size() && values.size() <= most; ++row)
      if (column < rows_[row].cells.size() && !rows_[row].cells[column].empty())
        ++values[rows_[row].cells[column]];
    return values;
  }

  // Whether the rows of each value of a column, taken alone, have growing times; of nowhere: all rows.
  bool separates(std::size_t column) const {
    std::map<std::string_view, double> last;
    for (std::size_t row = layout_.first; row < rows_.size(); ++row) {
      const Cells& cells = rows_[row].cells;
      const auto time = time_in(rows_[row]);
      if (!time) continue;
      const auto [at, first] = last.emplace(column < cells.size() ? cells[column] : "", *time);
      if (!first && !(*time > at->second)) return false;
      at->second = *time;
    }
    return true;
  }

  bool called_tool(std::size_t column) const {
    return layout_.header && column < rows_[*layout_.header].cells.size() &&
           is_of_tool(rows_[*layout_.header].cells[column]);
  }

  std::string title(std::size_t column) const {
    if (layout_.header && column < rows_[*layout_.header].cells.size())
      return std::string(rows_[*layout_.header].cells[column]);
    return fmt::format("column {}", column + 1);
  }

  // The column of tool names. It is found by its title, or because times grow within the rows of each value but not
  // over all rows.
  std::optional<std::size_t> column_of_tools() const {
    const bool mixed = timed() && !separates(nowhere);
    const std::size_t width = rows_[layout_.first].cells.size();
    for (const bool by_title : {true, false})
      for (std::size_t column = 0; column < width; ++column) {
        if (std::ranges::find(layout_.at, column) != layout_.at.end()) continue;
        if (by_title ? !called_tool(column) : !mixed) continue;
        const auto values = values_in(column, 64);
        if (values.size() < 2 || values.size() > 64) continue;
        if (2 * values.size() > rows_.size() - layout_.first) continue;  // too many values: a row counter
        if (by_title || separates(column)) return column;
      }
    return {};
  }

  void choose_tool() {
    if (own_columns_) return;
    if (format_.tool.empty()) {
      if (const auto column = column_of_tools()) fail_with_tools(*column, "holds several tools");
      return;
    }
    std::vector<std::size_t> holding;
    const std::size_t width = rows_[layout_.first].cells.size();
    for (std::size_t column = 0; column < width; ++column) {
      if (std::ranges::find(layout_.at, column) != layout_.at.end()) continue;
      const auto values = values_in(column, 64);
      if (values.size() <= 64 && values.contains(format_.tool)) holding.push_back(column);
    }
    if (holding.size() > 1) std::erase_if(holding, [&](std::size_t c) { return !called_tool(c); });
    if (holding.size() == 1) {
      layout_.names = holding.front();
      return;
    }
    if (const auto column = column_of_tools())
      fail_with_tools(*column, fmt::format("has no tool '{}'", format_.tool));
    throw InputError({.file = name_},
                     fmt::format("has no tool '{}', expected a name in one of its columns, or "
                                 "columns called {}_x, {}_y, {}_z",
                                 format_.tool, format_.tool, format_.tool, format_.tool));
  }

  [[noreturn]] void fail_with_tools(std::size_t column, const std::string& problem) const {
    std::vector<std::string> names;
    for (const auto& [value, count] : values_in(column, 64)) names.emplace_back(value);
    throw InputError({.file = name_, .line = rows_[layout_.first].line},
                     fmt::format("{} ({}), expected tool=NAME with one of {}", problem, title(column),
                                 fmt::join(names, ", ")));
  }

  // The time of a row of data [s].
  double time_of(const Row& row, std::size_t sample) const {
    if (!timed()) return static_cast<double>(sample) / format_.rate;
    const std::size_t at = layout_.at[0];
    if (at >= row.cells.size())
      throw InputError({.file = name_, .line = row.line},
                       fmt::format("a row of {} values, expected at least {}", row.cells.size(), at + 1));
    const auto time = time_in(row);
    if (!time || !std::isfinite(*time))
      throw InputError({.file = name_, .line = row.line},
                       fmt::format("the time is '{}', expected a finite number", row.cells[at]));
    return *time * format_.second;
  }

  Vec3 position_of(const Row& row) const {
    Vec3 x = Vec3::Zero();
    const std::size_t skip = timed() ? 1 : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t at = layout_.at[skip + axis];
      if (at == nowhere) continue;
      double value = 0;
      const bool given = at < row.cells.size() && trace_number(row.cells[at], value);
      if (!given && at < row.cells.size() && !trace_missing(row.cells[at]))
        throw InputError(
            {.file = name_, .line = row.line},
            fmt::format("the position is '{}', expected a number, or nothing where it is missing",
                        row.cells[at]));
      x[static_cast<int>(axis)] = given ? value * format_.metre : absent;
    }
    return x;
  }

  TraceRows take() {
    TraceRows out;
    double begin = 0;
    std::size_t sample = 0;
    for (std::size_t i = layout_.first; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      if (layout_.names && (*layout_.names >= row.cells.size() || row.cells[*layout_.names] != format_.tool))
        continue;
      const Vec3 x = position_of(row);
      const double t = time_of(row, sample++);
      if (!x.allFinite()) {
        if (missing_ == MissingPositions::refuse)
          throw InputError({.file = name_, .line = row.line},
                           "the position is not three finite numbers, expected x,y,z [m]");
        ++out.missing;
        continue;
      }
      if (out.times.empty()) begin = t;
      out.times.push_back(t - begin);
      out.positions.push_back(x);
      out.lines.push_back(row.line);
    }
    if (out.times.empty()) throw InputError({.file = name_}, "holds no row with a position, expected some");
    const std::size_t width = rows_[layout_.first].cells.size();
    for (std::size_t column = 0; column < width; ++column) {
      if (std::ranges::find(layout_.at, column) != layout_.at.end() || layout_.names == column) continue;
      ++out.ignored;
      out.orientation = out.orientation || is_of_orientation(title(column));
      out.times_unused = out.times_unused || (!timed() && is_of_time(title(column)));
    }
    return out;
  }

  std::string name_;
  const TraceFormat& format_;
  MissingPositions missing_;
  std::string content_;
  std::vector<Row> rows_;
  Layout layout_;
  bool own_columns_ = false;
};

}  // namespace

bool parse_trace_unit(const std::string& text, TraceFormat& format) {
  static const std::map<std::string, double> lengths{{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}};
  static const std::map<std::string, double> times{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};
  bool length = false, time = false;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t end = std::min(text.find('/', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (const auto found = lengths.find(word); found != lengths.end() && !std::exchange(length, true))
      format.metre = found->second;
    else if (const auto at = times.find(word); at != times.end() && !std::exchange(time, true))
      format.second = at->second;
    else
      return false;
    if (end == text.size()) return true;
    begin = end + 1;
  }
}

TraceRows read_trace_rows(const std::filesystem::path& file, const TraceFormat& format,
                          MissingPositions missing) {
  return Reader(file, format, missing).read();
}

}  // namespace forefeel
