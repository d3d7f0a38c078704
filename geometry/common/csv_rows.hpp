#pragma once
// Splits a CSV file into rows, and each row into cells of text. All readers of CSV files use it.
//   Cells are separated by commas. White space around a cell is dropped, and so are quotes around a whole
//   cell. Commas and line breaks inside quotes are not supported.
//   Blank lines, lines that begin with # and a byte order mark are skipped.
// csv_table.hpp reads columns of numbers, csv_text.hpp columns of text.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/error.hpp"

namespace forefeel {

class CsvRows {
 public:
  // content: of the whole file; it must outlive this object. name: of the file, for messages.
  CsvRows(const std::string& content, std::string name);

  // InputError if the last line has no line break. A file that forefeel wrote ends with one; without it, the
  // file was cut short.
  void expect_whole_lines() const;

  bool next();                     // to the next row; false after the last
  void again() { again_ = true; }  // the following next() stays at this row

  std::span<const std::string_view> cells() const { return cells_; }  // of this row; views into the content
  std::size_t line() const { return line_; }                          // of this row, from 1
  const std::string& name() const { return name_; }
  InputPlace where() const { return {.file = name_, .line = line_}; }
  [[noreturn]] void fail(const std::string& problem) const { throw InputError(where(), problem); }

 private:
  std::string name_;
  std::string_view left_;
  std::vector<std::string_view> cells_;
  std::size_t line_ = 0;
  bool again_ = false;
};

}  // namespace forefeel
