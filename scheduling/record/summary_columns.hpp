#pragma once
// A summary as a list of named values, in the order of summary.json. Names are the keys joined by dots
// ("error.first_visit.p95"). The notes are left out: they are a list of lines.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "scheduling/record/summary.hpp"

namespace forefeel {

// Unknown, boolean, integer, number or text.
using ColumnValue = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

struct Column {
  std::string name;
  ColumnValue value;
};

ColumnValue column_value(double value);  // unknown if it is not finite

std::vector<Column> summary_columns(const SessionSummary& summary);
// The last of these, which tables of studies keep behind their own columns.
std::vector<Column> later_columns(const SessionSummary& summary);

}  // namespace forefeel
