#pragma once
// Prints and writes the error bars of states without a session, for evaluate and classify.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "approx/error/known_within.hpp"
#include "approx/methods/evaluate.hpp"
#include "geometry/common/declared.hpp"

namespace forefeel {

// Adds the keys bar90, bar95 and bar99 (lists by point) and error_bar (the measured coverage). Null without bars.
void describe_bars(nlohmann::ordered_json& document, const std::optional<EvaluatedBars>& bars);
// "error bars of 90/95/99 %: … of 312 comparisons with known forces, left out in groups, lie inside …", with a warning
// if the share is more than five points below a level.
std::string bars_in_words(const EvaluatedBars& bars);

// ",0.1,0.2,0.5": cells of a CSV file, empty where infinite.
std::string bar_cells(const BarWidths& bar);
std::vector<Declared> declared_bars();       // bar90, bar95, bar99
std::vector<Declared> declared_bars_json();  // what describe_bars() writes
std::vector<Declared> declared_left_out();   // what write_left_out_vtu() writes
// The forces left out as a point cloud for ParaView: error and bars at their positions.
void write_left_out_vtu(const std::filesystem::path& file, const OfflineBars& bars);

// The spacing that the data suggest, with its reason.
std::string advice_in_words(const SpacingAdvice& advice, const Tolerance& tolerance);
nlohmann::ordered_json advice_json(const SpacingAdvice& advice);

}  // namespace forefeel
