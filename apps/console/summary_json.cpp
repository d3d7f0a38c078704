#include "apps/console/summary_json.hpp"

#include <fmt/format.h>

#include <type_traits>

#include "apps/console/contact_json.hpp"
#include "apps/console/outputs.hpp"
#include "geometry/common/counted.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/shape_files.hpp"

namespace forefeel {

namespace {

double ratio(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : unknown;
}

}  // namespace

const JsonKeys<ToleranceShown>& tolerance_keys() {
  using T = ToleranceShown;
  static const JsonKeys<T> keys{
      {"value", "", "state_space.tolerance if the scene gives it: a share or newtons",
       [](const T& t) { return t.tolerance.value; }},
      {"unit", "", "1 or N", [](const T& t) { return t.tolerance.newtons ? "N" : "1"; }},
      {"known", "1", "share of the frames whose error bar of 95 % is at most the tolerance",
       [](const T& t) { return ratio(t.share.frames_known, t.share.frames); }},
      {"samples", "", "sampled frames", [](const T& t) { return t.share.samples; }},
      {"within", "1", "share of the samples whose error is at most the tolerance",
       [](const T& t) { return ratio(t.share.within, t.share.samples); }},
      {"samples_known", "", "samples whose error bar of 95 % is at most the tolerance",
       [](const T& t) { return t.share.known; }},
      {"known_true", "1", "share of those whose error is at most the tolerance",
       [](const T& t) { return ratio(t.share.known_true, t.share.known); }}};
  return keys;
}

std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance) {
  std::string text = fmt::format("known within {} (bar of 95 %): {:.1f} % of the time", in_words(tolerance),
                                 100 * ratio(share.frames_known, share.frames));
  if (share.known > 0)
    text += fmt::format("; true in {:.1f} % of {} then", 100 * ratio(share.known_true, share.known),
                        counted(share.known, "sample"));
  return text;
}

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
const JsonKeys<SessionSummary>& extra_keys() {
  using S = SessionSummary;
  static const JsonKeys<S> keys{
      {"error_bar.levels", "1", "list: the levels of coverage.p90, coverage.p95 and coverage.p99",
       [](const S&) {
         return json_numbers({0.90, 0.95, 0.99});
       }},
      {"discretisation_interval", "1", "[low, high]: an interval that holds the true error; null: not known",
       [](const S& s) {
         return json_numbers({s.error.mesh.low, s.error.mesh.high});
       }},
      {"safety.force_limit", "N", "force limit of this session: that of the scene or of the device",
       [](const S& s) { return s.safety.force_limit; }},
      {"attention", "", "list of lines: warnings to read before the figures", attention},
      {"notes", "", "list of lines: what the system refused, what failed",
       [](const S& s) { return s.run.notes; }},
      {"failures", "", "list of lines: what ended the session or cost it results",
       [](const S& s) { return s.run.failures; }},
      {"interrupted", "", "true: ended early, or samples have no reference",
       [](const S& s) { return s.run.interrupted; }},
      {"frames_asked", "", "frames that the session should have had",
       [](const S& s) { return s.run.frames_asked; }},
      {"spacing", "m", "spacing of the state space", [](const S& s) { return s.settings.spacing; }}};
  return keys;
}

}  // namespace

nlohmann::ordered_json to_json(std::span<const Column> columns) {
  nlohmann::ordered_json document;
  for (const Column& column : columns) put(document, column.name, to_json(column.value));
  return document;
}

nlohmann::ordered_json to_json(const SessionSummary& summary) {
  nlohmann::ordered_json document = to_json(summary_columns(summary));
  add_to(document, extra_keys(), summary);
  return document;
}

DeclaredTable summary_output() {
  std::vector<Declared> rows = declared_columns(summary_columns({}));
  const auto add = [&](const std::vector<Declared>& more) {
    rows.insert(rows.end(), more.begin(), more.end());
  };
  add(declared(extra_keys()));
  std::vector<Declared> shape = below("shape", declared_columns(shape_columns({})));
  for (Declared& row : shape) row.meaning += "; with session.shape_rate";
  add(shape);
  add(below("prediction.NAME[]", declared(prediction_keys())));
  add(below("contact", declared(contact_keys())));
  add({{"spacing_auto.KEY", "", "", "with spacing = auto: how it was chosen"},
       {"field.KEY", "", "",
        "with contact.anywhere: sites, depth and friction of the field at rest, and what it took"},
       {"provenance.KEY", "", "", "program, machine and inputs"}});
  add(below("tolerance", declared(tolerance_keys())));
  return {"summary.json", "Summary of a session: keys joined by dots.", rows};
}

const JsonKeys<PredictionError>& prediction_keys() {
  using P = PredictionError;
  static const JsonKeys<P> keys{
      {"horizon", "s", "how far ahead the predictor of this name looked", &P::horizon},
      {"p50", "m", "median of |predicted - true position|",
       [](const P& p) { return p.p95 > 0 ? p.p50 : unknown; }},
      {"p95", "m", "95th percentile of that", [](const P& p) { return p.p95 > 0 ? p.p95 : unknown; }},
      {"within_two_deviations", "1",
       "share of the true coordinates within two standard deviations of the predicted one",
       &P::within_deviation},
      {"within_50", "1", "share of the true positions within the ball that should hold 50 % of them",
       &P::within_50},
      {"within_90", "1", "the same for 90 %", &P::within_90}};
  return keys;
}

nlohmann::ordered_json to_json(std::span<const PredictorErrors> predictors) {
  nlohmann::ordered_json document = nlohmann::ordered_json::object();
  for (const PredictorErrors& one : predictors) {
    auto& rows = document[one.predictor] = nlohmann::ordered_json::array();
    for (const PredictionError& e : one.by_horizon) rows.push_back(document_of(prediction_keys(), e));
  }
  return document;
}

}  // namespace forefeel
