#pragma once
// A CSV file with a header line: the cells of the current row by the names of their columns. Private to this room.

#include <array>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/types.hpp"
#include "geometry/states/named_columns.hpp"

namespace forefeel {

inline constexpr std::array<const char*, 6> required_columns{"x", "y", "z", "fx", "fy", "fz"};
inline constexpr std::array<const char*, 3> place_columns{"x", "y", "z"};

class NamedRows {
 public:
  // required: columns that must be there, and their order in a file without a header line (if that is allowed).
  NamedRows(const std::filesystem::path& file, std::span<const char* const> required, bool header_optional);
  // Columns of required_columns, or x,y,z with at most one other: its name is value() then. Without a header line three
  // or four numbers.
  explicit NamedRows(const std::filesystem::path& file);
  // Only these columns, by the names of required_columns.
  NamedRows(const std::filesystem::path& file, const NamedColumns& given);

  bool next();
  bool has(std::string_view column) const { return columns_.contains(column); }
  std::string_view text(std::string_view column) const {
    return rows_.cells()[columns_.find(column)->second];
  }

  double finite(std::string_view column) const;
  double optional(std::string_view column) const;  // empty or nan: unknown
  double distance(std::string_view column) const;  // the same, but it may be infinite
  Vec3 vector(const char* x, const char* y, const char* z) const;
  [[noreturn]] void fail(const std::string& problem) const { rows_.fail(problem); }
  const std::string& name() const { return rows_.name(); }

  const std::string& value() const { return value_; }  // the only column beside x,y,z; empty: none

  // read(rows) of each row that is left, in their order; by all threads if they are many.
  template <class Row, class Read>
  std::vector<Row> read_all(Read&& read) const;

 private:
  // The rows that are left, cut into parts, and the most rows that each may hold.
  struct Parts;
  Parts parts() const;
  bool only_numbers() const;
  void take_order(std::span<const char* const> names);
  void check_separator() const;
  void read_header(std::span<const char* const> required);

  std::shared_ptr<const std::string> content_;
  CsvRows rows_;
  std::map<std::string, std::size_t, std::less<>> columns_;
  std::string value_;
  std::set<std::string, std::less<>> turned_;  // columns of the other sign
  std::size_t width_ = 0;
};

struct NamedRows::Parts {
  std::vector<NamedRows> rows;
  std::vector<std::size_t> first;  // row of each part if every line holds one; then their number
};

template <class Row, class Read>
std::vector<Row> NamedRows::read_all(Read&& read) const {
  Parts all = parts();
  std::vector<Row> found(all.first.back());
  std::vector<std::size_t> count(all.rows.size(), 0);
  std::vector<std::exception_ptr> failed(all.rows.size());
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t p = 0; p < all.rows.size(); ++p) {
    try {
      while (all.rows[p].next()) found[all.first[p] + count[p]++] = read(all.rows[p]);
    } catch (...) {
      failed[p] = std::current_exception();
    }
  }
  for (const std::exception_ptr& error : failed)
    if (error) std::rethrow_exception(error);
  std::size_t kept = 0;
  for (std::size_t p = 0; p < all.rows.size(); ++p)
    for (std::size_t i = all.first[p]; i < all.first[p] + count[p]; ++i, ++kept)
      if (i != kept) found[kept] = std::move(found[i]);
  found.resize(kept);
  return found;
}

}  // namespace forefeel
