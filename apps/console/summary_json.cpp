#include "apps/console/summary_json.hpp"

#include <nlohmann/json.hpp>
#include <type_traits>

#include "apps/console/json.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/shape_summary.hpp"

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

namespace {

// Keys whose values are lists, or that the tables of studies do not have.
struct Extra {
  const char *table, *key, *unit, *meaning;
  nlohmann::ordered_json (*value)(const SessionSummary&);
};
using Json = nlohmann::ordered_json;
constexpr Extra extras[] = {
    {"error_bar", "levels", "1", "list: the levels of coverage.p90, coverage.p95 and coverage.p99",
     [](const SessionSummary&) {
       return Json{0.90, 0.95, 0.99};
     }},
    {"safety", "force_limit", "N", "force limit of this session: that of the scene or of the device",
     [](const SessionSummary& s) { return to_json(column_value(s.safety.force_limit)); }},
    {nullptr, "attention", "", "list of lines: warnings to read before the figures",
     [](const SessionSummary& s) { return Json(attention(s)); }},
    {nullptr, "notes", "", "list of lines: what the system refused, what failed",
     [](const SessionSummary& s) { return Json(s.run.notes); }},
    {nullptr, "failures", "", "list of lines: what ended the session or cost it results",
     [](const SessionSummary& s) { return Json(s.run.failures); }},
    {nullptr, "interrupted", "", "true: ended early, or samples have no reference",
     [](const SessionSummary& s) { return Json(s.run.interrupted); }},
    {nullptr, "frames_asked", "", "frames that the session should have had",
     [](const SessionSummary& s) { return Json(s.run.frames_asked); }},
    {nullptr, "spacing", "m", "spacing of the state space",
     [](const SessionSummary& s) { return Json(s.settings.spacing); }}};

}  // namespace

nlohmann::ordered_json to_json(std::span<const Column> columns) {
  nlohmann::ordered_json document;
  for (const Column& column : columns) {
    nlohmann::ordered_json* place = &document;  // "error.parts.switch" becomes nested objects
    std::size_t begin = 0;
    for (std::size_t dot; (dot = column.name.find('.', begin)) != std::string::npos; begin = dot + 1)
      place = &(*place)[column.name.substr(begin, dot - begin)];
    (*place)[column.name.substr(begin)] = to_json(column.value);
  }
  return document;
}

nlohmann::ordered_json to_json(const SessionSummary& summary) {
  nlohmann::ordered_json document = to_json(summary_columns(summary));
  for (const Extra& extra : extras) {
    nlohmann::ordered_json* place = &document;
    if (extra.table) place = &document[extra.table];
    (*place)[extra.key] = extra.value(summary);
  }
  return document;
}

std::vector<Declared> declared_summary_json() {
  std::vector<Declared> rows = declared_summary();
  for (const Extra& extra : extras)
    rows.push_back(
        {(extra.table ? extra.table + std::string(".") : "") + extra.key, extra.unit, "", extra.meaning});
  for (Declared row : declared_columns(shape_columns({}))) {
    row.name = "shape." + row.name;
    row.meaning += "; with session.shape_rate";
    rows.push_back(std::move(row));
  }
  for (Declared row : declared_prediction()) {
    row.name = "prediction.NAME[]." + row.name;
    rows.push_back(std::move(row));
  }
  rows.push_back({"spacing_auto.KEY", "", "", "with spacing = auto: how it was chosen"});
  rows.push_back({"provenance.KEY", "", "", "program, machine and inputs"});
  return rows;
}

std::vector<Declared> declared_prediction() {
  return {{"horizon", "s", "", "how far ahead the predictor of this name looked"},
          {"p50", "m", "", "median of |predicted - true position|"},
          {"p95", "m", "", "95th percentile of that"},
          {"within_two_deviations", "1", "",
           "share of the true coordinates within two standard deviations of the predicted one"}};
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
