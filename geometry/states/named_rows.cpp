#include "geometry/states/named_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/states/state.hpp"

namespace forefeel {
namespace {

constexpr std::size_t bytes_in_part = 1 << 19;

std::shared_ptr<const std::string> shared_text(const std::filesystem::path& file) {
  return std::make_shared<const std::string>(read_text_file(file));
}

}  // namespace

NamedRows::NamedRows(const std::filesystem::path& file, std::span<const char* const> required,
                     bool header_optional)
    : content_(shared_text(file)), rows_(*content_, file.string()) {
  if (!rows_.next())
    throw InputError({.file = rows_.name()},
                     fmt::format("holds no header line, expected {}", fmt::join(required, ",")));
  if (header_optional && only_numbers())
    take_order(required);
  else
    read_header(required);
}

NamedRows::NamedRows(const std::filesystem::path& file)
    : content_(shared_text(file)), rows_(*content_, file.string()) {
  if (!rows_.next()) throw InputError({.file = rows_.name()}, "holds no row, expected x,y,z or x,y,z,VALUE");
  const std::vector<std::string_view> cells(rows_.cells().begin(), rows_.cells().end());
  if ((cells.size() == 3 || cells.size() == 4) && only_numbers()) {
    take_order(place_columns);
    if (cells.size() == 4) columns_[value_ = "value"] = 3, width_ = 4;
    return;
  }
  const auto is_force = [](std::string_view name) { return name == "fx" || name == "fy" || name == "fz"; };
  std::vector<std::string_view> others;
  std::ranges::copy_if(cells, std::back_inserter(others), [](std::string_view name) {
    return std::ranges::find(place_columns, name) == place_columns.end() && name != "h";
  });
  const bool bare = others.size() < 2 && std::ranges::none_of(others, is_force);
  read_header(bare ? std::span<const char* const>(place_columns) : required_columns);
  if (bare && !others.empty()) value_ = others[0];
}

NamedRows::NamedRows(const std::filesystem::path& file, const NamedColumns& given)
    : content_(shared_text(file)), rows_(*content_, file.string()) {
  if (!rows_.next()) throw InputError({.file = rows_.name()}, "holds no header line, expected one");
  check_separator();
  const auto cells = rows_.cells();
  width_ = cells.size();
  if (given.size() == 4) value_ = given[3].substr(given[3].starts_with('-') ? 1 : 0);
  for (std::size_t k = 0; k < given.size(); ++k) {
    const bool turned = given[k].starts_with('-');
    const std::string_view name = std::string_view(given[k]).substr(turned ? 1 : 0);
    const auto called = [&](std::string_view cell) { return trimmed(cell) == name; };
    const auto found = std::ranges::find_if(cells, called);
    if (found == cells.end())
      fail(fmt::format("no column {:.40} of --columns, the header has {:.300}", name, fmt::join(cells, ",")));
    if (std::ranges::count_if(cells, called) > 1) fail(fmt::format("column {:.40} is there twice", name));
    const std::string meant = k == 3 && given.size() == 4 ? value_ : required_columns[k];
    columns_[meant] = static_cast<std::size_t>(found - cells.begin());
    if (turned) turned_.insert(meant);
  }
}

bool NamedRows::next() {
  if (!rows_.next()) return false;
  if (rows_.cells().size() != width_)
    fail(fmt::format("{} columns, expected {}", rows_.cells().size(), width_));
  return true;
}

double NamedRows::finite(std::string_view column) const {
  double value = 0;
  const std::string_view cell = text(column);
  if (!parse_real(cell, value)) fail(fmt::format("column {}: '{:.40}' is not a number", column, cell));
  if (!std::isfinite(value)) fail(fmt::format("column {}: '{:.40}' is not finite", column, cell));
  return !turned_.empty() && turned_.contains(column) ? -value : value;
}

double NamedRows::optional(std::string_view column) const {
  if (text(column).empty() || lower_case(text(column)) == "nan") return unknown;
  return finite(column);
}

double NamedRows::distance(std::string_view column) const {
  const std::string word = lower_case(text(column));
  return word == "inf" || word == "infinity" ? std::numeric_limits<double>::infinity() : optional(column);
}

Vec3 NamedRows::vector(const char* x, const char* y, const char* z) const {
  const double a = finite(x), b = finite(y), c = finite(z);
  return {a, b, c};
}

bool NamedRows::only_numbers() const {
  double number = 0;
  return std::ranges::all_of(rows_.cells(), [&](std::string_view cell) { return parse_real(cell, number); });
}

// The row at hand is the first one, its columns are these.
void NamedRows::take_order(std::span<const char* const> names) {
  for (std::size_t i = 0; i < names.size(); ++i) columns_[names[i]] = i;
  width_ = names.size();
  rows_.again();
}

void NamedRows::check_separator() const {
  const auto cells = rows_.cells();
  if (cells.size() == 1 && cells[0].find_first_of(";\t") != std::string_view::npos)
    fail("columns are not separated by commas, expected a comma-separated file");
}

void NamedRows::read_header(std::span<const char* const> required) {
  check_separator();
  const auto cells = rows_.cells();
  std::string_view twice;
  width_ = cells.size();
  for (std::size_t i = 0; i < width_; ++i)
    if (!columns_.emplace(std::string(cells[i]), i).second) twice = cells[i];
  for (const char* column : required)
    if (!columns_.contains(column))
      fail(fmt::format("no column {}, expected a header line with {}{}; this one begins with '{:.40}'",
                       column, fmt::join(required, ","),
                       required.front() == required_columns.front() && required.size() == 6
                           ? " (import --columns takes other names; classify and import take x,y,z alone, or "
                             "with one value)"
                           : "",
                       cells[0]));
  if (!twice.empty()) fail(fmt::format("column {:.40} is there twice", twice));
}

NamedRows::Parts NamedRows::parts() const {
  Parts all;
  std::size_t lines = 0;
  for (CsvRows& rows : rows_.parts(bytes_in_part)) {
    all.first.push_back(lines);
    lines += rows.most_rows();
    NamedRows& part = all.rows.emplace_back(*this);
    part.rows_ = std::move(rows);
  }
  all.first.push_back(lines);
  return all;
}

}  // namespace forefeel
