#pragma once
// A session's summary as JSON: the keys of summary.json up to `notes`, in their order. Unknown values are null.

#include <nlohmann/json_fwd.hpp>

#include "scheduling/record/summary_columns.hpp"

namespace forefeel {

nlohmann::ordered_json to_json(const ColumnValue& value);
nlohmann::ordered_json to_json(const SessionSummary& summary);

}  // namespace forefeel
