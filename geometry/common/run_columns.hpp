#pragma once
// The columns of a run's tables, and how rows become text. A column is declared once: name, unit, meaning and cells.

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <future>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
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
  virtual void vector(const Vec3& value) = 0;
  virtual void whole(std::int64_t value) = 0;
  virtual void flag(bool value) = 0;
  virtual void word(std::string_view word, std::uint8_t number) = 0;  // of an enumeration
};

class RowText final : public Cells {
 public:
  // Shortest text that reads back to the same double; empty where unknown.
  void real(double value) override {
    if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), "{}", value == 0 ? 0.0 : value);
  }
  void vector(const Vec3& value) override {
    for (int i = 0; i < 3; ++i) {
      if (i > 0) text.push_back(',');
      real(value[i]);
    }
  }
  void whole(std::int64_t value) override { fmt::format_to(std::back_inserter(text), "{}", value); }
  void flag(bool value) override { text.push_back(value ? '1' : '0'); }
  void word(std::string_view word, std::uint8_t) override { text.append(word); }

  fmt::memory_buffer text;
};

inline constexpr std::uint8_t no_word = 255;

enum class Only : std::uint8_t {
  always,
  real,
  viscous,
  anywhere
};  // under which circumstances a column is shown

// One column, or the columns of a vector: header, unit, meaning, and the function that puts its cells.
template <class Record>
struct RunColumn {
  std::string_view names, unit, meaning;
  void (*put)(Cells&, const Record&);
  std::string_view array = "";  // its name in Python, where that is not `names`
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
std::string header_of(std::span<const RunColumn<Record>> columns, const Circumstances& of) {
  std::string header;
  for (const RunColumn<Record>& column : columns)
    if (of.show(column.only)) header += (header.empty() ? "" : ",") + std::string(column.names);
  return header + '\n';
}

template <class Record>
RowText rows_of(std::span<const Record> records, std::span<const RunColumn<Record>> columns,
                const Circumstances& of) {
  RowText out;
  for (const Record& record : records) {
    for (const RunColumn<Record>& column : columns) {
      if (!of.show(column.only)) continue;
      if (&column != columns.data()) out.text.push_back(',');
      column.put(out, record);
    }
    out.text.push_back('\n');
  }
  return out;
}

// The parts of a long table are formatted in parallel.
template <class Record>
void write_rows(const std::filesystem::path& file, std::span<const Record> records,
                std::span<const RunColumn<Record>> columns, const Circumstances& of) {
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

template <class Record>
std::vector<Declared> declared(std::span<const RunColumn<Record>> columns) {
  std::vector<Declared> rows;
  for (const RunColumn<Record>& column : columns)
    rows.push_back({std::string(column.names), std::string(column.unit), "",
                    std::string(column.meaning) + (column.only == Only::real       ? "; real clock only"
                                                   : column.only == Only::viscous  ? "; viscous bodies only"
                                                   : column.only == Only::anywhere ? "; contact.anywhere only"
                                                                                   : "")});
  return rows;
}

}  // namespace forefeel
