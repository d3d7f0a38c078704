#include "apps/classify/run_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

template <class Cells>
void split(std::string_view line, Cells& cells) {
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.emplace_back(line.substr(begin, end - begin));
    if (end == line.size()) return;
    begin = end + 1;
  }
}

double parsed(std::string_view cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool whole = error == std::errc{} && end == cell.data() + cell.size() && !cell.empty();
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

RunTable RunTable::read(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError({.file = file.string()}, "cannot be read, expected a file of a run");
  RunTable table;
  std::ostringstream all;
  all << in.rdbuf();
  table.file_ = std::make_shared<const std::string>(std::move(all).str());
  std::string_view left = *table.file_;
  for (std::size_t number = 1; !left.empty(); ++number) {
    std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(left.size(), line.size() + 1));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (number == 1) {
      split(line, table.columns_);
      table.cells_.reserve(table.columns_.size() *
                           static_cast<std::size_t>(std::ranges::count(left, '\n') + 1));
      continue;
    }
    const std::size_t before = table.cells_.size();
    split(line, table.cells_);
    if (table.cells_.size() - before != table.columns_.size())
      throw InputError(
          fmt::format("{}:{}", file.string(), number),
          fmt::format("has {} cells, expected {}", table.cells_.size() - before, table.columns_.size()));
  }
  if (table.columns_.empty()) throw InputError({.file = file.string()}, "is empty, expected a header line");
  return table;
}

std::optional<std::size_t> RunTable::index(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) return {};
  return static_cast<std::size_t>(found - columns_.begin());
}

std::string_view RunTable::text(std::size_t row, std::string_view column) const {
  const std::optional<std::size_t> at = index(column);
  return at ? cells_[row * columns_.size() + *at] : std::string_view();
}

double RunTable::number(std::size_t row, std::string_view column) const {
  return parsed(text(row, column));
}

std::vector<double> RunTable::numbers(std::string_view column) const {
  const std::optional<std::size_t> at = index(column);
  std::vector<double> values(rows(), std::numeric_limits<double>::quiet_NaN());
  if (!at) return values;
  for (std::size_t row = 0; row < values.size(); ++row)
    values[row] = parsed(cells_[row * columns_.size() + *at]);
  return values;
}

}  // namespace forefeel
