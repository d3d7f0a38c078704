#pragma once
// Steps that a hand feels, counted from frames.csv alone: runs of rows whose force sent differs from that ten rows
// before by more than the columns of the motion explain, and than 7 % (10 mN).

#include <algorithm>
#include <cmath>
#include <regex>
#include <string>

#include "geometry/common/csv_rows.hpp"
#include "geometry/common/types.hpp"

namespace forefeel::test {

struct FeltInTable {
  std::size_t count = 0;
  double largest = 0, largest_share = 0;  // [N], [1]
};

inline FeltInTable felt_in(const CsvText& frames) {
  const auto sent = [&](std::size_t row) {
    return Vec3(frames.number(row, "fx"), frames.number(row, "fy"), frames.number(row, "fz"));
  };
  const char* const motion = frames.has("tip_change") ? "tip_change" : "motion_change";
  FeltInTable felt;
  bool before = false;
  for (std::size_t row = 10; row < frames.rows(); ++row) {
    double change = (sent(row) - sent(row - 10)).norm();
    for (std::size_t k = row - 9; k <= row; ++k) change -= frames.number(k, motion);
    const double force = std::max(sent(row).norm(), sent(row - 10).norm());
    const bool now = change > std::max(0.07 * force, 0.010) * (1 + 1e-6);
    if (now) {
      felt.count += !before;
      felt.largest = std::max(felt.largest, change);
      felt.largest_share = std::max(felt.largest_share, change / force);
    }
    before = now;
  }
  return felt;
}

// Of the sentence of a session: those within a touch and those that begin or end one are all that the table holds.
inline std::size_t felt_said(const std::string& out) {
  static const std::regex sentence(
      R"(felt +(\d+)  steps? of the force that a hand feels([^;\n]*)(; apart from these ([^;\n]*))?;)"),
      by(R"((\d+) by)");
  std::smatch line, part;
  REQUIRE(std::regex_search(out, line, sentence));
  std::size_t all = std::stoul(line[1]);
  for (std::string rest = line[4]; std::regex_search(rest, part, by); rest = part.suffix())
    all += std::stoul(part[1]);
  return all;
}

}  // namespace forefeel::test
