#include "apps/study/study_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/console/json.hpp"
#include "apps/console/summary_json.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/study/study_verdict.hpp"

namespace forefeel {
namespace {

using Json = nlohmann::ordered_json;

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

// Numbers as in JSON, with the fewest digits that read back to the same value.
std::string shown(const ColumnValue& value) {
  if (std::holds_alternative<std::monostate>(value)) return "";
  const auto* text = std::get_if<std::string>(&value);
  return text ? quoted(*text) : json_text(to_json(value));
}

std::vector<std::string> result_keys(const Study& study, const std::vector<StudyCellResult>& cells) {
  std::set<std::string> taken{"seed"};
  for (const StudyAxis& axis : study.axes) taken.insert(axis.column);
  std::vector<std::string> keys;
  for (const StudyCellResult& cell : cells)
    for (const Column& column : cell.columns())
      if (taken.insert(column.name).second) keys.push_back(column.name);
  return keys;
}

Json interval_json(const ConfidenceInterval& interval) {
  return Json::array({number(interval.low), number(interval.high)});
}

Json comparison_json(const Comparison& comparison, const StudyMetric& metric) {
  const bool larger = metric.larger_is_better;
  return {{"mean", number(comparison.student.mean)},
          {"student", interval_json(comparison.student)},
          {"bootstrap", interval_json(comparison.bootstrap)},
          {"pairs", comparison.pairs},
          {"traces", comparison.groups},
          {"p", number(comparison.p_value())},
          {"won", larger ? comparison.won : comparison.lost},
          {"lost", larger ? comparison.lost : comparison.won},
          {"verdict", larger ? comparison.verdict() : -comparison.verdict()}};
}

Json motions_for_2_points(const Comparison& difference, const StudyMetric& metric) {
  if (!metric.share || difference.won + difference.lost == 0) return nullptr;
  const auto needed = motions_needed(difference, 0.02);
  return needed ? Json(*needed) : Json(nullptr);
}

}  // namespace

std::string cells_csv(const Study& study, const std::vector<StudyCellResult>& cells) {
  const std::vector<std::string> keys = result_keys(study, cells);
  std::string text;
  for (const StudyAxis& axis : study.axes) text += quoted(axis.column) + ',';
  text += "seed";
  for (const std::string& key : keys) text += ',' + quoted(key);
  text += '\n';
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::vector<std::size_t> choice = study.choice(study.combination_of(i));
    for (std::size_t a = 0; a < choice.size(); ++a)
      text += quoted(study.axes[a].values[choice[a]].text) + ',';
    text += std::to_string(study.seed_of(i));
    for (const std::string& key : keys) {
      text += ',';
      if (const ColumnValue* value = cells[i].find(key)) text += shown(*value);
    }
    text += '\n';
  }
  return text;
}

Json ranking_json(const Study& study, const std::vector<AxisRanking>& ranked,
                  const std::vector<Contrast>& compared) {
  Json document;
  const StudyMetric metric = primary_metric(study);
  document["metric"] = metric.key;
  document["student_of_means"] = metric.share   ? "on the logit scale"
                                 : metric.ratio ? "of logarithms"
                                                : "plain";
  document["rankings"] = Json::array();
  for (const AxisRanking& entry : ranked) {
    Json rows = Json::array();
    for (const Ranked& row : entry.ranking.ranked)
      rows.push_back({{"value", study.axes[entry.axis].values[row.level].text},
                      {"result", comparison_json(row.value, metric)},
                      {"to_best", comparison_json(row.to_best, metric)},
                      {"tied", row.tied},
                      {"p_holm", number(row.holm)},
                      {"mean_rank", number(row.mean_rank)},
                      {"motions_for_2_points", motions_for_2_points(row.to_best, metric)},
                      {"bound", standing_of(study.axes[entry.axis], row.level) == Standing::bound},
                      {"placebo", standing_of(study.axes[entry.axis], row.level) == Standing::placebo}});
    document["rankings"].push_back({{"axis", study.axes[entry.axis].column},
                                    {"units", entry.ranking.blocks},
                                    {"units_dropped", entry.ranking.dropped},
                                    {"critical_difference", number(critical_difference(entry))},
                                    {"ranked", rows}});
  }
  document["contrasts"] = Json::array();
  for (const Contrast& contrast : compared) {
    Json row{{"axis", study.axes.front().column},
             {"value", study.axes.front().values[contrast.a].text},
             {"against", study.axes.front().values[contrast.b].text},
             {"metric", contrast.metric.key},
             {"compared_by", contrast.metric.ratio ? "difference of logarithms" : "difference"}};
    row["where"] = Json::object();
    if (contrast.slice)
      row["where"][study.axes[contrast.slice->axis].column] =
          study.axes[contrast.slice->axis].values[contrast.slice->value].text;
    row.update(comparison_json(contrast.comparison, contrast.metric));
    row["p_holm"] = number(contrast.holm);
    row["verdict"] = contrast.metric.larger_is_better ? contrast.verdict() : -contrast.verdict();
    document["contrasts"].push_back(row);
  }
  return document;
}

// ---- devices

std::vector<std::string> device_titles() {
  return {"device",  "motion", "session", "cells",      "first visits within the JND",
          "clamped", "slewed", "outside", "saturation", "energy given back"};
}

std::vector<std::string> device_row(const StudyDevice& d) {
  const auto share = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.3g} %", 100 * value) : std::string("–");
  };
  const auto seconds = [](double value) { return fmt::format("{:.4g} s", value); };
  return {d.device,
          std::isfinite(d.motion_seconds) ? seconds(d.motion_seconds) : "endless",
          seconds(d.seconds),
          std::to_string(d.cells),
          share_of_samples(d.within_jnd, d.first_visits),
          share(d.clamped),
          share(d.slewed),
          share(d.outside),
          share(d.busy),
          std::isfinite(d.generated) ? fmt::format("{:.3g} mJ", 1e3 * d.generated) : "–"};
}

Json devices_json(const std::vector<StudyDevice>& devices) {
  Json list = Json::array();
  for (const StudyDevice& d : devices)
    list.push_back({{"device", d.device},
                    {"motion_seconds", number(d.motion_seconds)},
                    {"seconds", number(d.seconds)},
                    {"cells", d.cells},
                    {"first_visits", d.first_visits},
                    {"within_jnd", number(d.within_jnd)},
                    {"clamped_share", number(d.clamped)},
                    {"slewed_share", number(d.slewed)},
                    {"time_outside", number(d.outside)},
                    {"busy_share", number(d.busy)},
                    {"generated_J", number(d.generated)}});
  return list;
}

}  // namespace forefeel
