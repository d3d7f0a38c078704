#include "scheduling/record/shape_summary.hpp"

#include <algorithm>
#include <string>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

double rank(const std::vector<double>& values, double share) {
  return quantile_of(values, share, QuantileRule::inverted_cdf);
}

template <class Value>
ShapeSummary::Errors errors_of(std::span<const CheckedShape> checked, Value value) {
  std::vector<double> all;
  for (const CheckedShape& one : checked)
    if (const double here = value(one); here >= 0) all.push_back(here);
  return {.samples = all.size(), .p50 = rank(all, 0.5), .p95 = rank(all, 0.95), .max = rank(all, 1)};
}

void add(std::vector<Column>& columns, const std::string& key, const ShapeSummary::Errors& errors,
         const char* meaning) {
  columns.push_back(
      {key + ".samples", std::uint64_t{errors.samples}, "", "shapes compared with tight solves"});
  columns.push_back({key + ".p50", column_value(errors.p50), "1", meaning});
  columns.push_back(
      {key + ".p95", column_value(errors.p95), "1", "95th percentile over the compared shapes"});
  columns.push_back({key + ".max", column_value(errors.max), "1", "the worst of them"});
}

}  // namespace

ShapeSummary summarise(const ShapeLog& log, std::span<const CheckedShape> checked) {
  ShapeSummary s{.rate = log.options().rate,
                 .surface = log.options().surface,
                 .nodes = log.nodes().size(),
                 .shapes = log.records().size(),
                 .missed = log.missed(),
                 .cost_us = {},
                 .error = errors_of(checked, [](const CheckedShape& c) { return c.error; }),
                 .nodes_p95 = errors_of(checked, [](const CheckedShape& c) { return c.node_p95; }),
                 .by_label = {}};
  for (const ShapeRecord& record : log.records()) {
    ++s.orders[static_cast<std::size_t>(record.order)];
    s.largest = std::max(s.largest, record.largest);
  }
  for (const Label label : all_labels)
    s.by_label[label] =
        errors_of(checked, [&](const CheckedShape& c) { return c.label == label ? c.error : -1.0; });
  const std::vector<double> costs(log.cost_us().begin(), log.cost_us().end());
  if (!costs.empty()) s.cost_us = {rank(costs, 0.5), rank(costs, 0.99), rank(costs, 1)};
  return s;
}

std::vector<Column> shape_columns(const ShapeSummary& s) {
  using Count = std::uint64_t;
  std::vector<Column> columns{
      {"rate", s.rate, "Hz", "shapes per second of the session (session.shape_rate)"},
      {"surface", s.surface, "", "true: nodes of the surface alone; false: of the whole body"},
      {"nodes", Count{s.nodes}, "", "nodes of a shape"},
      {"shapes", Count{s.shapes}, "", "shapes made"},
      {"missed", Count{s.missed}, "", "instants left out because the thread came too late; real clock"},
      {"orders.slope", Count{s.orders[0]}, "",
       "shapes of the nearest state and the slope of the body at rest"},
      {"orders.cubic", Count{s.orders[1]}, "", "shapes by the cubic kernel"},
      {"orders.quintic", Count{s.orders[2]}, "", "shapes by the quintic kernel"},
      {"largest", s.largest, "m", "largest displacement of a node"},
      {"cost_us.p50", column_value(s.cost_us.p50), "us", "median time to make a shape; real clock only"},
      {"cost_us.p99", column_value(s.cost_us.p99), "us", "99th percentile"},
      {"cost_us.max", column_value(s.cost_us.max), "us", "largest"}};
  add(columns, "error", s.error,
      "median over the compared shapes of the largest error of a node, relative to the largest displacement");
  add(columns, "error.node_p95", s.nodes_p95, "the same of the 95th percentile of the nodes");
  for (const Label label : all_labels)
    add(columns, "error.by_label." + std::string(name(label)), s.by_label[label],
        "median error where the tip has this label");
  return columns;
}

}  // namespace forefeel
