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

using RowText = fmt::memory_buffer;

// Shortest text that reads back to the same double; empty where unknown.
inline void put(RowText& out, double value) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(out), "{}", value == 0 ? 0.0 : value);
}
inline void put(RowText& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) {
    if (i > 0) out.push_back(',');
    put(out, v[i]);
  }
}
inline void put(RowText& out, std::string_view word) {
  out.append(word);
}
inline void put(RowText& out, std::int64_t number) {
  fmt::format_to(std::back_inserter(out), "{}", number);
}
inline void put(RowText& out, bool flag) {
  out.push_back(flag ? '1' : '0');
}

// One column, or the columns of a vector: header, unit, meaning, and the function that writes its cells.
template <class Record>
struct RunColumn {
  std::string_view names, unit, meaning;
  void (*write)(RowText&, const Record&);
  bool real = false;      // under the real clock only
  bool viscous = false;   // of a viscous body only
  bool anywhere = false;  // of a body that is touched anywhere only
};

struct Circumstances {
  bool real = false, viscous = false, anywhere = false;
  template <class Record>
  bool show(const RunColumn<Record>& column) const {
    return (real || !column.real) && (viscous || !column.viscous) && (anywhere || !column.anywhere);
  }
};

template <class Record>
std::string header_of(std::span<const RunColumn<Record>> columns, const Circumstances& of) {
  std::string header;
  for (const RunColumn<Record>& column : columns)
    if (of.show(column)) header += (header.empty() ? "" : ",") + std::string(column.names);
  return header + '\n';
}

template <class Record>
RowText rows_of(std::span<const Record> records, std::span<const RunColumn<Record>> columns,
                const Circumstances& of) {
  RowText out;
  for (const Record& record : records) {
    for (const RunColumn<Record>& column : columns) {
      if (!of.show(column)) continue;
      if (&column != columns.data()) out.push_back(',');
      column.write(out, record);
    }
    out.push_back('\n');
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
    out.write({mine.data(), mine.size()});
  }
  out.commit();
}

template <class Record>
std::vector<Declared> declared(std::span<const RunColumn<Record>> columns) {
  std::vector<Declared> rows;
  for (const RunColumn<Record>& column : columns)
    rows.push_back({std::string(column.names), std::string(column.unit), "",
                    std::string(column.meaning) + (column.real       ? "; real clock only"
                                                   : column.viscous  ? "; viscous bodies only"
                                                   : column.anywhere ? "; contact.anywhere only"
                                                                     : "")});
  return rows;
}

}  // namespace forefeel
