#pragma once
// Prints and writes the error bars of states without a session, for evaluate and classify.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "approx/error/error_bar.hpp"
#include "approx/methods/evaluate.hpp"
#include "apps/console/document_keys.hpp"

namespace forefeel {

// bar90, bar95 and bar99 (lists by point, empty without points) and error_bar (the measured coverage). Null without
// bars.
struct BarsShown {
  const EvaluatedBars* bars = nullptr;
  bool points = true;
};
const JsonKeys<BarsShown>& bar_keys();
// What the states tell: forces, or values in a unit that nobody said.
struct Told {
  std::string unit = " N", things = "forces";
};
// "expected error p50 0.1 N, p95 0.3 N: of 312 comparisons with known forces, …"
std::string expectation_in_words(const AutoModel& chosen, const SharedError& shared, const Told& told = {});
// "error bars of 90/95/99 %: … of 312 comparisons with known forces, left out in groups, lie inside …", with a warning
// if the share is more than five points below a level.
// asked_for: bars.at are those of a table, and have a median of their own.
std::string bars_in_words(const EvaluatedBars& bars, bool asked_for = false, const Told& told = {});

// Of the columns bar90, bar95 and bar99 of a CSV file, empty where infinite.
inline constexpr std::string_view bar_meaning =
    "half-widths of the error bars around the approximated force, from known forces left out in groups; "
    "empty "
    "where too few are known for that level";

// The forces left out as a point cloud for ParaView: error and bars at their positions.
void write_left_out_vtu(const std::filesystem::path& file, const OfflineBars& bars);

// The spacing that the data suggest, with its reason.
std::string advice_in_words(const SpacingAdvice& advice, const Tolerance& tolerance);
const JsonKeys<SpacingAdvice>& advice_keys();

}  // namespace forefeel
