#include "apps/console/summary_json.hpp"

#include <nlohmann/json.hpp>
#include <type_traits>

#include "apps/console/json.hpp"
#include "scheduling/record/attention.hpp"

namespace forefeel {

nlohmann::ordered_json to_json(const ColumnValue& value) {
  return std::visit(
      [](const auto& held) {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, std::monostate>)
          return nlohmann::ordered_json(nullptr);
        else
          return nlohmann::ordered_json(held);
      },
      value);
}

nlohmann::ordered_json to_json(const SessionSummary& summary) {
  nlohmann::ordered_json document;
  for (const Column& column : summary_columns(summary)) {
    nlohmann::ordered_json* place = &document;  // "error.parts.switch" becomes nested objects
    std::size_t begin = 0;
    for (std::size_t dot; (dot = column.name.find('.', begin)) != std::string::npos; begin = dot + 1)
      place = &(*place)[column.name.substr(begin, dot - begin)];
    (*place)[column.name.substr(begin)] = to_json(column.value);
  }
  document["safety"]["force_limit"] = to_json(column_value(summary.safety.force_limit));
  document["attention"] = attention(summary);
  document["notes"] = summary.run.notes;
  document["failures"] = summary.run.failures;
  return document;
}

nlohmann::ordered_json to_json(std::span<const PredictorErrors> predictors) {
  nlohmann::ordered_json document = nlohmann::ordered_json::object();
  for (const PredictorErrors& one : predictors) {
    auto& rows = document[one.predictor] = nlohmann::ordered_json::array();
    for (const PredictionError& e : one.by_horizon)
      rows.push_back({{"horizon", e.horizon},
                      {"p50", number(e.p95 > 0 ? e.p50 : unknown)},
                      {"p95", number(e.p95 > 0 ? e.p95 : unknown)},
                      {"within_two_deviations", number(e.within_deviation)}});
  }
  return document;
}

}  // namespace forefeel
