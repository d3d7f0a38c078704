#include "scheduling/record/shape_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "geometry/common/error.hpp"
#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/mesh/vtu_series.hpp"

namespace forefeel {

namespace {

namespace fs = std::filesystem;

std::string file_of(std::size_t k) {
  return fmt::format("shape/shape_{:06}.vtu", k);
}

bool is_shape_file(const std::string& name) {
  return name.starts_with("shape_") && name.ends_with(".vtu");
}

// Does not sync the file to the disk. The .pvd lists all files and is written after them.
void write_file(const fs::path& file, const std::string& content) {
  errno = 0;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  if (!out)
    throw InputError({.file = file.string()},
                     fmt::format("cannot be written: {}", errno ? std::strerror(errno) : "unknown error"));
}

struct ShapeRow {
  const ShapeRecord& shape;
  const CheckedShape* checked;  // null: not compared
};

constexpr Field<ShapeRow> shape_file_columns[] = {
    {"t", "s", "time of the shape", [](Cells& o, const ShapeRow& r) { put(o, r.shape.t); }},
    {"x,y,z", "m", "position of the tip then", [](Cells& o, const ShapeRow& r) { put(o, r.shape.at); }},
    {"known", "", "number of known states", [](Cells& o, const ShapeRow& r) { put(o, r.shape.known); }},
    {"states", "", "states that the shape is interpolated from, besides rest and the slope there",
     [](Cells& o, const ShapeRow& r) { put(o, r.shape.states.size()); }},
    {"order", "",
     "quintic, cubic, or slope: the slope of the body at rest and the nearest state, of touches those near",
     [](Cells& o, const ShapeRow& r) { put(o, r.shape.order); }},
    {"largest", "m", "largest displacement of a node",
     [](Cells& o, const ShapeRow& r) { put(o, r.shape.largest); }},
    {"error", "1",
     "largest error of a node against a tight solve, relative to the largest displacement; empty: not "
     "compared",
     [](Cells& o, const ShapeRow& r) { put(o, r.checked ? r.checked->error : unknown); }}};

// Removes the files of the series. Other files in the folder stay.
void clear_series(const fs::path& run) {
  std::error_code error;
  fs::remove(run / "shape.pvd", error);
  if (!fs::is_directory(run / "shape", error)) return;
  for (const auto& entry : fs::directory_iterator(run / "shape", error))
    if (is_shape_file(entry.path().filename().string())) fs::remove(entry.path(), error);
  fs::remove(run / "shape", error);  // only if it is empty
}

bool is_ours(const fs::path& pvd) {
  try {
    return std::ranges::all_of(read_pvd(pvd),
                               [](const SeriesFile& one) { return one.file.starts_with("shape/shape_"); });
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

void remove_shape_files(const fs::path& run) {
  std::error_code error;
  if (!fs::exists(run / "shape.pvd", error) || !is_ours(run / "shape.pvd")) return;
  clear_series(run);
  fs::remove(run / "shape.csv", error);
}

void write_shape_series(const fs::path& run, const ShapeLog& log) {
  clear_series(run);
  try {
    const VtuSeries series(log.body().mesh, log.nodes(), log.options().surface);
    std::error_code error;
    fs::create_directories(run / "shape", error);
    std::vector<SeriesFile> files;
    std::vector<float> u;
    for (std::size_t k = 0; k < log.records().size(); ++k) {
      const ShapeRecord& record = log.records()[k];
      log.displacements(record, u);
      files.push_back({.t = record.t, .file = file_of(k)});
      write_file(run / files.back().file, series.frame(record.t, record.at, u));
    }
    write_pvd(run / "shape.pvd", files);
  } catch (...) {
    clear_series(run);
    throw;
  }
}

void write_shape_table(const fs::path& run, const ShapeLog& log, std::span<const CheckedShape> checked) {
  std::string table = header_of<ShapeRow>(shape_file_columns);
  auto next = checked.begin();
  for (std::size_t k = 0; k < log.records().size(); ++k) {
    const bool compared = next != checked.end() && next->record == k;
    table += csv_row<ShapeRow>(shape_file_columns, {log.records()[k], compared ? &*next : nullptr});
    if (compared) ++next;
  }
  write_whole(run / "shape.csv", table);
}

DeclaredTable declared_shape_table() {
  return {"shape.csv",
          "One row a shape, in sessions with session.shape_rate. The displacements are in shape.pvd.",
          declared<ShapeRow>(shape_file_columns)};
}

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
