#include "geometry/common/csv_rows.hpp"

#include <algorithm>
#include <utility>

#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

std::string_view without_quotes(std::string_view cell) {
  const bool quoted = cell.size() >= 2 && cell.front() == '"' && cell.back() == '"';
  return quoted ? cell.substr(1, cell.size() - 2) : cell;
}

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(without_quotes(trimmed(line.substr(0, comma))));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
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
  throw InputError({.file = name_, .line = line_ + lines + 1},
                   "the file ends within this line, expected a whole file: it was cut short");
}

bool CsvRows::next() {
  if (std::exchange(again_, false)) return true;
  while (!left_.empty()) {
    const std::string_view line = left_.substr(0, left_.find('\n'));
    left_.remove_prefix(std::min(left_.size(), line.size() + 1));
    ++line_;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') continue;
    split(line, cells_);
    return true;
  }
  return false;
}

}  // namespace forefeel
