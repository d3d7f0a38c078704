#pragma once
// The columns of a CSV file that is written. Each is declared once: name, unit, meaning, and the cells of a row. From
// the columns come header, rows and `forefeel help`.
//
//   const CsvColumns<Sample> columns{{"x,y,z", "m", "position", [](const Sample& s) { return cells(s.at); }},
//                                    {"error", "1", "relative", [](const Sample& s) { return known_cell(s.error); }}};

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "geometry/common/declared.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

template <class Row>
struct CsvColumn {
  std::string name, unit, meaning;  // columns of a vector share a row: "x,y,z"
  std::function<std::string(const Row&)> cells;
};
template <class Row>
using CsvColumns = std::vector<CsvColumn<Row>>;

inline std::string cells(const Vec3& value) {
  return fmt::format("{},{},{}", value[0], value[1], value[2]);
}
// Empty where the value is not finite.
inline std::string known_cell(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

template <class Row>
std::vector<Declared> declared(const CsvColumns<Row>& columns) {
  std::vector<Declared> rows;
  for (const CsvColumn<Row>& column : columns) rows.push_back({column.name, column.unit, "", column.meaning});
  return rows;
}

// With line break.
template <class Row>
std::string csv_header(const CsvColumns<Row>& columns) {
  return header_of(declared(columns)) + "\n";
}
template <class Row>
std::string csv_row(const CsvColumns<Row>& columns, const Row& row) {
  std::string text;
  for (const CsvColumn<Row>& column : columns) text += (text.empty() ? "" : ",") + column.cells(row);
  return text + "\n";
}

}  // namespace forefeel
