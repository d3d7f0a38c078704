#pragma once
// A summary as a list of named values, in the order of summary.json. Names are the keys joined by dots
// ("error.first_visit.p95"). The notes are left out: they are a list of lines.

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/record/summary.hpp"

namespace forefeel {

// Unknown, boolean, integer, number or text.
using ColumnValue = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

struct Column {
  std::string name;
  ColumnValue value;
  std::string_view unit = {}, meaning = {};  // for `forefeel help`; literals
};

ColumnValue column_value(double value);  // unknown if it is not finite

std::vector<Column> summary_columns(const SessionSummary& summary);
// The last of these columns. In cells.csv of a study they follow the study's own columns.
std::vector<Column> later_columns(const SessionSummary& summary);

// For `forefeel help`. The four labels share a row, "error.by_label.LABEL.p50".
std::vector<Declared> declared_columns(const std::vector<Column>& columns);

}  // namespace forefeel
