// forefeel classify [STATES] --calibrate SCENE [-o DIR/]: error statistics per label on this body.
// The states are the given ones or the scene's lattice. The references are tight solves at random positions
// in the scene's box, kept in the cache folder. For foreign states they are a part of the states, left out.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/offline/calibrate_labels.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/page.hpp"
#include "apps/picture/plot.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/laboratory.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "scheduling/study/calibration.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t truth_positions = 160;

// The known states, the reference states and the spacing.
struct CalibrationData {
  std::vector<State> pool = {}, truth = {};
  double spacing = unknown;
  bool left_out = false;  // the truth is a part of the given states
};

std::vector<State> solved_truth(Laboratory& laboratory, std::uint64_t seed, Progress& progress) {
  const std::vector<Vec3> at = calibration_positions(laboratory.scene().space.box, truth_positions, seed);
  std::vector<State> truth = laboratory.references(
      at, [&](double share, const std::string& text) { progress.show(0.3 + 0.5 * share, text); });
  std::erase_if(truth, [](const State& s) { return !s.usable(); });
  return truth;
}

CalibrationData given_data(Laboratory& laboratory, const CalibrateArguments& arguments, std::uint64_t seed) {
  const Scene& scene = laboratory.scene();
  GivenStates given = given_states(laboratory.globals(), scene, arguments.states, arguments.foreign);
  std::vector<State>& states = given.loaded.states;
  std::erase_if(states, [](const State& s) { return !s.usable(); });
  CalibrationData data{.spacing = given.loaded.header.spacing};
  if (!(data.spacing > 0)) data.spacing = scene.space.spacing;
  data.left_out = given.belonging == Belonging::foreign;
  const std::size_t least = data.left_out ? 20 : 4;
  if (states.size() < least)
    throw InputError(arguments.states,
                     fmt::format("holds {} usable states, expected at least {}", states.size(), least));
  if (data.left_out) {
    HeldOut parts = hold_out(std::move(states), truth_positions, seed);
    data.pool = std::move(parts.pool);
    data.truth = std::move(parts.truth);
  } else {
    data.pool = std::move(states);
  }
  return data;
}

CalibrationData data_of(Laboratory& laboratory, const CalibrateArguments& arguments, std::uint64_t seed,
                        Progress& progress) {
  if (!arguments.states.empty()) return given_data(laboratory, arguments, seed);
  const Scene& scene = laboratory.scene();
  return {.pool = laboratory.lattice_states(
              scene.space.box, scene.space.spacing,
              [&](double share, const std::string& text) { progress.show(0.3 * share, text); }),
          .truth = {},
          .spacing = scene.space.spacing};
}

nlohmann::ordered_json to_json(const Calibration& found, const CalibrationOptions& options) {
  nlohmann::ordered_json document;
  document["tolerance"] = options.tolerance;
  document["select"] = name(options.select);
  document["spacing"] = options.space.spacing;
  document["sets"] = nlohmann::ordered_json::array();
  for (const KnownSet& set : found.sets) document["sets"].push_back(set.name);
  for (const Label label : all_labels)
    document["positions"][std::string(name(label))] = found.positions[label];
  document["table"] = nlohmann::ordered_json::array();
  for (const CalibrationCell& cell : found.table) {
    nlohmann::ordered_json row;
    row["kernel"] = name(found.kinds[cell.kind].model.kernel);
    row["data"] = name(found.kinds[cell.kind].model.data);
    row["neighbours"] = found.kinds[cell.kind].model.neighbours;
    row["label"] = name(cell.label);
    row["count"] = cell.count;
    row["over_tolerance"] = number(cell.share);
    row["over_tolerance_low"] = number(cell.low);
    row["over_tolerance_high"] = number(cell.high);
    row["error"] = {{"p50", number(cell.p50)},
                    {"p90", number(cell.p90)},
                    {"p95", number(cell.p95)},
                    {"p99", number(cell.p99)},
                    {"max", number(cell.max)}};
    document["table"].push_back(row);
  }
  document["ranks"] = nlohmann::ordered_json::array();
  for (const CalibrationRanks& r : found.ranks)
    document["ranks"].push_back({{"kernel", name(found.kinds[r.kind].model.kernel)},
                                 {"data", name(found.kinds[r.kind].model.data)},
                                 {"label", number(r.label)},
                                 {"delta", number(r.delta)},
                                 {"spread", number(r.spread)},
                                 {"power", number(r.power)}});
  return document;
}

std::string value(double v) {
  return std::isfinite(v) ? fmt::format("{:.5g}", v) : std::string();
}

void write_tables(const Calibration& found, const fs::path& folder) {
  std::string table = "kernel,data,neighbours,label,count,over_tolerance,low,high,p50,p90,p95,p99,max\n";
  for (const CalibrationCell& c : found.table) {
    const ModelOptions& m = found.kinds[c.kind].model;
    table += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", name(m.kernel), name(m.data),
                         m.neighbours, name(c.label), c.count, value(c.share), value(c.low), value(c.high),
                         value(c.p50), value(c.p90), value(c.p95), value(c.p99), value(c.max));
  }
  write_whole(folder / "calibration.csv", table);
  std::string ranks = "kernel,data,neighbours,label,delta,spread,power\n";
  for (const CalibrationRanks& r : found.ranks) {
    const ModelOptions& m = found.kinds[r.kind].model;
    ranks += fmt::format("{},{},{},{},{},{},{}\n", name(m.kernel), name(m.data), m.neighbours, value(r.label),
                         value(r.delta), value(r.spread), value(r.power));
  }
  write_whole(folder / "ranks.csv", ranks);
  std::string samples = "kernel,data,neighbours,set,position,label,delta,spread,power,error\n";
  for (const CalibrationSample& s : found.samples) {
    const ModelOptions& m = found.kinds[s.kind].model;
    samples += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", name(m.kernel), name(m.data), m.neighbours,
                           found.sets[s.set].name, s.position, name(s.label), value(s.delta), value(s.spread),
                           value(s.power), value(s.error));
  }
  write_whole(folder / "samples.csv", samples);
}

// One group of kinds per label: a bar from the median to 95 %, a point for the largest error.
Figure picture(const Calibration& found, double tolerance) {
  std::string script, plot, tics;
  const double width = 0.8 / static_cast<double>(found.kinds.size());
  for (std::size_t kind = 0; kind < found.kinds.size(); ++kind) {
    std::string lines;
    for (const CalibrationCell& c : found.table)
      if (c.kind == kind && c.count > 0)
        lines += fmt::format("{} {:.4g} {:.4g} {:.4g}\n",
                             static_cast<double>(c.label) - 0.4 + width * (static_cast<double>(kind) + 0.5),
                             std::max(1e-4, 100 * c.p50), std::max(1e-4, 100 * c.p95),
                             std::max(1e-4, 100 * c.max));
    script += data_block(fmt::format("k{}", kind), lines);
    plot += fmt::format(
        ", $k{0} using 1:2:2:3 with yerrorbars pt 7 ps 0.8 lw 3 lc rgb '{1}' title '{2}', $k{0} using 1:4 "
        "with points pt 2 ps 0.8 lw 1.6 lc rgb '{1}' notitle",
        kind, line_colour(kind), found.kinds[kind].name);
  }
  for (std::size_t l = 0; l < 4; ++l)
    tics += fmt::format("{}'{}\\n{} positions' {}", l > 0 ? ", " : "", name(static_cast<Label>(l)),
                        found.positions[l], l);
  // '\n' is a line break in double quotes only.
  std::ranges::replace(tics, '\'', '"');
  script += plot_style;
  script += fmt::format(
      "set logscale y\nset yrange [1e-4:*]\nset format y '10^{{%T}}'\nset ylabel 'relative error [%]'\nset "
      "xrange [-0.5:3.5]\nset xtics ({}) scale 0\n"
      "set grid noxtics\nset bmargin 3.6\nset key outside top center horizontal samplen 1.5 font ',12'\nplot "
      "{} with lines lw 1 dt 2 lc rgb '#6a6a6a' notitle{}\n",
      tics, 100 * tolerance, plot);
  return {
      "calibration",
      fmt::format(
          "Error by label: dot the median, bar up to the 95 % quantile, cross the largest; dashed {:g} %.",
          100 * tolerance),
      960, 440, script};
}

std::string percent(double share) {
  return !std::isfinite(share) ? "–"
         : share == 0          ? "0"
         : share < 1e-3        ? fmt::format("{:.1e}", 100 * share) + " %"
                               : fmt::format("{:.3g} %", 100 * share);
}

const char* truth_in_words(bool left_out) {
  return left_out ? "truth: groups of the given states, left out (nothing is solved)"
                  : "truth by tight solves at random positions of the box";
}

void write_page(const Calibration& found, const CalibrationOptions& options, const std::string& name_of_scene,
                bool left_out, const fs::path& folder) {
  std::vector<std::vector<std::string>> table{{"model", "label", "positions",
                                               fmt::format("P(error > {:g} %)", 100 * options.tolerance),
                                               "95 % interval", "p50", "p95", "max"}};
  for (const CalibrationCell& c : found.table)
    table.push_back({found.kinds[c.kind].name, std::string(name(c.label)), std::to_string(c.count),
                     percent(c.share),
                     c.count > 0 ? fmt::format("{} to {}", percent(c.low), percent(c.high)) : "–",
                     percent(c.p50), percent(c.p95), percent(c.max)});
  std::vector<std::vector<std::string>> ranks{{"model", "label", "distance δ", "spread π", "power function"}};
  for (const CalibrationRanks& r : found.ranks)
    ranks.push_back({found.kinds[r.kind].name, fmt::format("{:.2f}", r.label), fmt::format("{:.2f}", r.delta),
                     fmt::format("{:.2f}", r.spread), fmt::format("{:.2f}", r.power)});
  std::string sets;
  for (const KnownSet& set : found.sets) sets += (sets.empty() ? "" : ", ") + set.name;
  std::string html = fmt::format(
      "<h1>What labels say about the error</h1>\n<p class=\"sub\">{}, spacing {:.4g} mm, neighbours by {}; "
      "known sets: {}; {}.</p>\n",
      html_escaped(name_of_scene), 1e3 * options.space.spacing, name(options.select), sets,
      truth_in_words(left_out));
  html += draw_into(folder, picture(found, options.tolerance)) + "<h2>By label</h2>\n" + html_table(table) +
          "<h2>What ranks the error</h2>\n<p class=\"muted\">Spearman's rank correlation with the true "
          "error, over all positions of all sets.</p>\n" +
          html_table(ranks);
  write_whole(folder / "report.html", html_page("Forefeel: calibration of labels", html));
}

void tell(const Globals& globals, const Calibration& found, const CalibrationOptions& options) {
  for (std::size_t kind = 0; kind < found.kinds.size(); ++kind) {
    std::string line = fmt::format("{:26}", found.kinds[kind].name);
    for (const CalibrationCell& c : found.table)
      if (c.kind == kind) line += fmt::format(" {} p95 {:.2g} P {:.2f};", name(c.label), c.p95, c.share);
    const CalibrationRanks& r = found.ranks[kind];
    say(globals,
        line + fmt::format(" rank label {:.2f} delta {:.2f} power {:.2f}", r.label, r.delta, r.power));
  }
  say(globals, fmt::format("P is P(error > {:g} %); positions: {} safe, {} sparse, {} gap, {} blank",
                           100 * options.tolerance, found.positions[0], found.positions[1],
                           found.positions[2], found.positions[3]));
}

}  // namespace

int calibrate_labels(const Globals& globals, const CalibrateArguments& arguments) {
  Laboratory laboratory(globals, arguments.scene);
  std::optional<Progress> progress(std::in_place, globals, "calibrate");
  CalibrationData data = data_of(laboratory, arguments, globals.seed, *progress);
  const std::string& output = arguments.output;
  if (!output.empty())
    claim_folder(output, {"calibration.csv", "ranks.csv", "samples.csv", "report.html", "summary.json"});
  if (!data.left_out) data.truth = solved_truth(laboratory, globals.seed, *progress);
  const Scene& s = laboratory.scene();
  CalibrationOptions options{.space = s.space,
                             .inward = s.inward,
                             .tolerance = s.spacing.tolerance,
                             .floor = s.session.judging.error_floor,
                             .select = s.model.select,
                             .seed = globals.seed,
                             .threads = globals.threads};
  options.space.spacing = data.spacing;
  progress->show(0.9, "models");
  const Calibration found = calibrate(data.pool, data.truth, options);
  progress->show(0.95, "the mesh itself");
  const MeshError mesh = MeshErrorTask(s, MeshErrorTask::When::at_the_end).get();
  progress.reset();
  nlohmann::ordered_json document = to_json(found, options);
  document["truth"] = data.left_out ? "left out" : "solved";
  add_to(document, mesh_error_keys(), mesh);
  document["provenance"] = provenance(s.source.hash);
  if (!output.empty()) {
    const fs::path folder = output;
    write_tables(found, folder);
    write_page(found, options, laboratory.name(), data.left_out, folder);
    write_whole(folder / "summary.json", json_text(document, 2) + "\n");
  }
  if (globals.json) print_json(document);
  tell(globals, found, options);
  say(globals, discretisation_line(mesh, unknown));
  say(globals, truth_in_words(data.left_out));
  if (!output.empty()) say(globals, fmt::format("report: {}", (fs::path(output) / "report.html").string()));
  return 0;
}

}  // namespace forefeel
