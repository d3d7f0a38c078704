#pragma once
// Error bars of states without a session, as evaluate and classify print and write them.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "approx/evaluate/evaluate.hpp"
#include "approx/judge/known_within.hpp"
#include "geometry/common/declared.hpp"

namespace forefeel {

// The keys bar90, bar95 and bar99, by point, and error_bar: what was measured. Null without bars.
void describe_bars(nlohmann::ordered_json& document, const std::optional<EvaluatedBars>& bars);
// "95 % of 312 forces left out in groups lie inside their bar of 95 % …"; where fewer do by five points, it says so.
std::string bars_in_words(const EvaluatedBars& bars);

// ",0.1,0.2,0.5": cells of a CSV file, empty where infinite.
std::string bar_cells(const BarWidths& bar);
std::vector<Declared> declared_bars();       // bar90, bar95, bar99
std::vector<Declared> declared_bars_json();  // what describe_bars() writes
std::vector<Declared> declared_left_out();   // of left_out_vtu()
// Cloud of the forces left out: error and bars at their positions, for ParaView.
void write_left_out_vtu(const std::filesystem::path& file, const OfflineBars& bars);

// The spacing that the data suggest, with its reason; spacing: the one in use [m].
std::string advice_in_words(const SpacingAdvice& advice, const Tolerance& tolerance);
nlohmann::ordered_json advice_json(const SpacingAdvice& advice);

}  // namespace forefeel
