#pragma once
// The columns of a table. Each is declared once: name, unit, meaning, and what puts its cells. From these come a CSV
// file, `forefeel help outputs` and Python's arrays.
//
//   const Field<Sample> fields[] = {
//       {"x,y,z", "m", "position", [](Cells& o, const Sample& s) { put(o, s.at); }},
//       {"error", "1", "relative", [](Cells& o, const Sample& s) { put(o, s.error); }}};
//   text += csv_row<Sample>(fields, sample);

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <future>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "geometry/common/declared.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

// What the cells of a row are put into: text here, arrays in Python.
class Cells {
 public:
  virtual ~Cells() = default;
  virtual void real(double value) = 0;  // unknown where not finite
  virtual void vector(std::span<const double> values) = 0;
  virtual void whole(std::int64_t value) = 0;
  virtual void flag(bool value) = 0;
  virtual void word(std::string_view word, std::uint8_t number) = 0;  // of an enumeration
};

class RowText final : public Cells {
 public:
  // Shortest text that reads back to the same double; empty where unknown.
  void real(double value) override {
    if (std::isfinite(value))
      fmt::format_to(std::back_inserter(text), "{}", value == 0 && !minus_zero ? 0.0 : value);
  }
  void vector(std::span<const double> values) override {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) text.push_back(',');
      real(values[i]);
    }
  }
  void whole(std::int64_t value) override { fmt::format_to(std::back_inserter(text), "{}", value); }
  void flag(bool value) override { text.push_back(value ? '1' : '0'); }
  void word(std::string_view word, std::uint8_t) override { text.append(word); }

  fmt::memory_buffer text;
  bool minus_zero = false;  // true: -0 is written "-0"
};

inline constexpr std::uint8_t no_word = 255;

// The cell of a value by its type.
inline void put(Cells& o, double value) {
  o.real(value);
}
inline void put(Cells& o, bool value) {
  o.flag(value);
}
inline void put(Cells& o, const Vec3& value) {
  o.vector({value.data(), 3});
}
template <std::integral Whole>
void put(Cells& o, Whole value) {
  o.whole(static_cast<std::int64_t>(value));
}
template <class Word>
requires std::is_enum_v<Word>
void put(Cells& o, Word value) {
  o.word(name(value), static_cast<std::uint8_t>(value));
}

enum class Only : std::uint8_t {
  always,
  real,
  viscous,
  anywhere
};  // under which circumstances a column is shown

// One column, or the columns of a vector: header, unit, meaning, and the function that puts its cells.
template <class Record>
struct Field {
  std::string_view name, unit, meaning;
  void (*put)(Cells&, const Record&);
  std::string_view array = "";  // its name in Python, where that is not `name`
  Only only = Only::always;
};

struct Circumstances {
  bool real = false;      // the real clock
  bool viscous = false;   // a viscous body
  bool anywhere = false;  // a body that is touched anywhere
  bool show(Only only) const {
    return only == Only::always || (only == Only::real ? real : only == Only::viscous ? viscous : anywhere);
  }
};

template <class Record>
std::string header_of(std::span<const Field<Record>> columns, const Circumstances& of = {}) {
  std::string header;
  for (const Field<Record>& column : columns)
    if (of.show(column.only)) header += (header.empty() ? "" : ",") + std::string(column.name);
  return header + '\n';
}

template <class Record>
void put_row(RowText& out, const Record& record, std::span<const Field<Record>> columns,
             const Circumstances& of = {}) {
  for (const Field<Record>& column : columns) {
    if (!of.show(column.only)) continue;
    if (&column != columns.data()) out.text.push_back(',');
    column.put(out, record);
  }
  out.text.push_back('\n');
}

template <class Record>
std::string csv_row(std::span<const Field<Record>> columns, const Record& record) {
  RowText out;
  out.minus_zero = true;
  put_row(out, record, columns);
  return fmt::to_string(out.text);
}

template <class Record>
RowText rows_of(std::span<const Record> records, std::span<const Field<Record>> columns,
                const Circumstances& of) {
  RowText out;
  for (const Record& record : records) put_row(out, record, columns, of);
  return out;
}

// The parts of a long table are formatted in parallel.
template <class Record>
void write_rows(const std::filesystem::path& file, std::span<const Record> records,
                std::span<const Field<Record>> columns, const Circumstances& of) {
  const std::size_t n = records.size(), parts = n < 1000 ? 1 : 4;
  std::vector<std::future<RowText>> texts;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = part * n / parts, last = (part + 1) * n / parts;
    texts.push_back(std::async(std::launch::async, [mine = records.subspan(first, last - first), columns,
                                                    of] { return rows_of(mine, columns, of); }));
  }
  OutputFile out(file);
  out.write(header_of(columns, of));
  for (std::future<RowText>& text : texts) {
    const RowText mine = text.get();
    out.write({mine.text.data(), mine.text.size()});
  }
  out.commit();
}

// Writes row(i), the text of row i with its line end, of `count` rows: formatted by all threads, some thousands at a
// time.
template <class Row>
void write_lines(OutputFile& out, std::size_t count, Row&& row) {
  constexpr std::size_t part = 4096, parts = 64;
  std::vector<std::string> texts(parts);
  for (std::size_t begin = 0; begin < count; begin += part * parts) {
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t k = 0; k < parts; ++k) {
      texts[k].clear();
      const std::size_t first = begin + k * part, last = std::min(count, first + part);
      for (std::size_t i = first; i < last; ++i) texts[k] += row(i);
    }
    for (const std::string& text : texts) out.write(text);
  }
}

template <class Record>
std::vector<Declared> declared(std::span<const Field<Record>> columns) {
  std::vector<Declared> rows;
  for (const Field<Record>& column : columns)
    rows.push_back({std::string(column.name), std::string(column.unit), "",
                    std::string(column.meaning) + (column.only == Only::real       ? "; real clock only"
                                                   : column.only == Only::viscous  ? "; viscous bodies only"
                                                   : column.only == Only::anywhere ? "; contact.anywhere only"
                                                                                   : "")});
  return rows;
}

}  // namespace forefeel
