#pragma once
// Splits a CSV file into rows, and each row into cells of text. All readers of CSV files use it.
//   Cells are separated by commas. White space around a cell is dropped, and so are quotes around a whole
//   cell, inside which commas may stand, but no line breaks.
//   Blank lines, lines that begin with # and a byte order mark are skipped.
// CsvTable reads columns of numbers, CsvText columns of text.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
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

  // What is left, cut at ends of lines into parts of about so many bytes: whole if it holds a quote, which may hold a
  // line break. The first part also has the row of again().
  std::vector<CsvRows> parts(std::size_t bytes) const;
  std::size_t most_rows() const;  // left: one a line

  std::span<const std::string_view> cells() const { return cells_; }  // of this row; views into the content
  std::size_t line() const { return line_; }                          // its first, from 1
  const std::string& name() const { return name_; }
  InputPlace where() const { return {.file = name_, .line = line_}; }
  [[noreturn]] void fail(const std::string& problem) const { throw InputError(where(), problem); }

 private:
  std::string name_;
  std::string_view left_;
  std::vector<std::string_view> cells_;
  std::size_t line_ = 0, next_line_ = 1;
  bool again_ = false;
};

// Reads a CSV file with a header line and keeps every cell as text. Columns are found by name; a cell is
// converted to a number on request. For files whose cells may be empty or hold words; CsvTable is for
// columns of numbers only.

class CsvText {
 public:
  // InputError that names file and line: the file or its header is missing, a row differs from the header in
  // length, or the last line has no line break (the file was cut short). expected: what the message calls the
  // file ("a file of a run").
  static CsvText read(const std::filesystem::path& file, std::string_view expected);

  std::size_t rows() const { return lines_.size(); }
  std::size_t line(std::size_t row) const { return lines_[row]; }  // in the file, from 1
  bool has(std::string_view column) const { return index(column).has_value(); }
  std::string_view text(std::size_t row, std::string_view column) const;  // "" where the column is absent
  double number(std::size_t row, std::string_view column) const;  // NaN if absent, empty or not a number

 private:
  std::optional<std::size_t> index(std::string_view column) const;

  std::shared_ptr<const std::string> content_;  // what the cells are views of
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;  // #rows x #columns, row by row
  std::vector<std::size_t> lines_;       // #rows
};

// Reads columns of numbers from a CSV file. A header line names the columns, in any order; columns that were
// not asked for are ignored. If the first row holds numbers, there is no header, and columns are read by position.

struct CsvTable {
  std::size_t columns = 0;
  std::vector<double> values;      // #rows x columns, row by row
  std::vector<std::size_t> lines;  // #rows: line in the file, from 1

  std::size_t rows() const { return lines.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

// InputError that names file and line: missing file, no rows, missing column, a row shorter than
// the header, a cell that is not a finite number. whole_lines: also for a last line without a line break; forefeel's
// own files end with one.
CsvTable read_csv(const std::filesystem::path& file, std::span<const std::string_view> columns,
                  bool whole_lines = false);

}  // namespace forefeel
