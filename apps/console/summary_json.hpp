#pragma once
// A session's summary as JSON: the keys of summary.json up to `spacing`, in their order. Unknown values are null.

#include <span>
#include <string>
#include <vector>

#include "apps/console/document_keys.hpp"
#include "geometry/common/tolerance.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/record/summary_columns.hpp"
#include "scheduling/record/summary_parts.hpp"

namespace forefeel {

// Prints the share of the time for which a session knew the force within the tolerance of its scene.

struct ToleranceShown {
  const ToleranceShare& share;
  const Tolerance& tolerance;
};
const JsonKeys<ToleranceShown>& tolerance_keys();  // of `tolerance` in summary.json
std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance);

nlohmann::ordered_json to_json(const ColumnValue& value);
nlohmann::ordered_json to_json(std::span<const Column> columns);  // names with dots become nested objects
nlohmann::ordered_json to_json(const SessionSummary& summary);
const JsonKeys<PredictionError>& prediction_keys();  // of one row of `prediction`
// The key `prediction`: predictor -> rows by horizon [s], errors [m]. Null where nothing was compared.
nlohmann::ordered_json to_json(std::span<const PredictorErrors> predictors);

}  // namespace forefeel
