// forefeel reproduce timing|extrapolation|damping|energy|speed|all [SCENE] -o DIR/: repeats the paper's table
// and figures with our results beside them. Writes CSV, pictures and a page that compares the findings.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/picture/figure.hpp"
#include "apps/picture/page.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"

namespace forefeel {

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all{
      {"timing", "Time to update and to evaluate (section 4)", reproduce_timing},
      {"extrapolation", "Out of the known space (Fig. 2)", reproduce_extrapolation},
      {"damping", "States that arrive while the hand rests (Fig. 3)", reproduce_damping},
      {"energy", "Energy around closed loops", reproduce_energy},
      {"speed", "Sustained HIP speed against workers", reproduce_speed}};
  return all;
}

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.3g} %", 100 * share) : "–";
}

std::string paragraph(const std::string& lead, const std::string& text) {
  return "<p><b>" + html_escaped(lead) + ".</b> " + html_escaped(text) + "</p>\n";
}

namespace {

namespace fs = std::filesystem;

struct ReproduceArguments {
  std::optional<std::size_t> gap;  // limited by the depth
  std::string what, scene, output;
  ReproduceOptions options;
};

std::vector<Experiment> chosen(const std::string& what) {
  if (what == "all") return experiments();
  std::vector<std::string> names;
  for (const Experiment& experiment : experiments()) {
    if (experiment.name == what) return {experiment};
    names.push_back(experiment.name);
  }
  names.push_back("all");
  throw InputError("reproduce", fmt::format("'{}' is unknown{}", what, expected_instead(what, names)));
}

std::string page(const Laboratory& laboratory, const std::string& sections) {
  const Scene& scene = laboratory.scene();
  const auto made_by = provenance(scene.source.hash);
  std::string html = fmt::format(
      "<h1>The paper's experiments</h1>\n<p class=\"sub\">Peterlík and Filipovič, Haptic Rendering Based on "
      "RBF Approximation from "
      "Dynamically Updated Data. Here on {}: {} tetrahedra, {}, spacing {:.4g} mm.</p>\n",
      html_escaped(laboratory.name()), scene.body->mesh.tets.size(), name(scene.body->material.law),
      1e3 * laboratory.spacing());
  html += sections + "<h2>Provenance</h2>\n<table class=\"wide\">\n";
  for (const char* key : {"command", "version", "commit", "machine"})
    html += fmt::format("<tr><td>{}</td><td class=\"n\">{}</td></tr>\n", key,
                        html_escaped(made_by[key].get<std::string>()));
  return html_page("Forefeel: the paper's experiments", html + "</table>\n");
}

// Checks made before anything is written.
ReproduceOptions checked_options(const ReproduceArguments& arguments) {
  ReproduceOptions options = arguments.options;
  if (!std::isfinite(options.interval))
    throw InputError("--interval", fmt::format("is {}, expected 0.05 to 3600 s", options.interval));
  if (arguments.gap && *arguments.gap + 2 > options.depth)
    throw InputError("--gap", fmt::format("is {} spacings, expected at most {}: the depth is {}",
                                          *arguments.gap, options.depth - 2, options.depth));
  if (!std::isfinite(options.travel))
    throw InputError("--travel", fmt::format("is {}, expected 0.01 to 1000 m", options.travel));
  for (auto workers = options.workers.begin(); workers != options.workers.end(); ++workers)
    if (std::find(options.workers.begin(), workers, *workers) != workers)
      throw InputError("--workers", fmt::format("names {} twice, expected each number once", *workers));
  options.gap = arguments.gap.value_or(options.gap);
  return options;
}

// Which experiments read which option; `all` runs every experiment.
void refuse_unused(const std::string& what, const Command& sub) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> uses{
      {"--depth", {"extrapolation", "damping"}},
      {"--gap", {"extrapolation"}},
      {"--interval", {"damping"}},
      {"--rounds", {"timing"}},
      {"--travel", {"speed"}},
      {"--seeds", {"speed"}},
      {"--workers", {"speed"}}};
  for (const auto& [option, experiments_of] : uses)
    if (sub.given(option) && what != "all" && std::ranges::find(experiments_of, what) == experiments_of.end())
      throw InputError(option, fmt::format("without effect on reproduce {}, expected with {} or all", what,
                                           fmt::join(experiments_of, ", ")));
  if (what == "speed" && sub.given("--seed"))
    throw InputError("--seed",
                     "without effect on reproduce speed, expected --seeds N: the sessions of seeds 1 to N");
}

int run_reproduce(const Globals& globals, const ReproduceArguments& arguments, const Command& sub) {
  const std::vector<Experiment> wanted = chosen(arguments.what);
  refuse_unused(arguments.what, sub);
  const ReproduceOptions options = checked_options(arguments);
  if (wanted.back().name == "speed") check_speed_overrides(globals);
  Laboratory laboratory(globals, arguments.scene);
  const fs::path folder = arguments.output;
  if (wanted.back().name == "speed") {
    if (folder.empty()) throw InputError("--output", "is empty, expected a folder for the files of the run");
    check_speed(laboratory, options);
  }
  claim_folder(folder, {"*.csv", "*.svg", "*.toml", "report.html", "summary.json"});
  nlohmann::ordered_json document;
  document["scene"] = laboratory.name();
  document["experiments"] = nlohmann::ordered_json::object();
  const MeshError mesh = MeshErrorTask(laboratory.scene(), MeshErrorTask::When::at_the_end).get();
  add_to(document, mesh_error_keys(), mesh);
  say(globals, discretisation_line(mesh, unknown));
  std::string sections = "<p class=\"note\">" + html_escaped(discretisation_line(mesh, unknown)) + "</p>\n";
  bool all_met = true;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Experiment& experiment = wanted[i];
    Progress progress(globals, experiment.name);
    const Findings found =
        experiment.run(laboratory, options, folder,
                       [&](double share, const std::string& text) { progress.show(share, text); });
    document["experiments"][experiment.name] = found.summary;
    sections += fmt::format("<h2>{}</h2>\n{}", html_escaped(experiment.title), found.html);
    // Results are on disk before the next experiment begins.
    write_whole(folder / "report.html", page(laboratory, sections));
    for (const std::string& line : found.lines) say(globals, experiment.name + ": " + line);
    for (const std::string& line : found.unmet) warn(globals, experiment.name + ": " + line);
    all_met = all_met && found.unmet.empty();
  }
  document["provenance"] = provenance(laboratory.scene().source.hash);
  write_whole(folder / "summary.json", json_text(document, 2) + "\n");
  if (globals.json) print_json(document);
  say(globals, fmt::format("report: {}", (folder / "report.html").string()));
  return all_met ? 0 : 1;
}

}  // namespace

void add_reproduce(CommandLine& line) {
  const auto arguments = std::make_shared<ReproduceArguments>();
  Command sub = line.add("reproduce", "Repeat the paper's table and figures, with our results beside them");
  sub.runs([arguments, sub](const Globals& globals) { return run_reproduce(globals, *arguments, sub); });
  std::string names;
  for (const Experiment& experiment : experiments()) names += experiment.name + ", ";
  sub.option(
         "WHAT", arguments->what,
         names + "or all. speed runs hundreds of sessions, half an hour or more; an interrupted run resumes")
      .required();
  sub.option("SCENE", arguments->scene, "Scene; default: the built-in liver phantom");
  sub.option("-o,--output", arguments->output, "Folder for tables, pictures and the report")
      .required()
      .shows("DIR/");
  sub.option("--depth", arguments->options.depth, "Length of the path in spacings")
      .between(4, 100)
      .shows_default();
  sub.option("--gap", arguments->gap,
             "Width of the gap of `extrapolation` in spacings, at most depth - 2 [8]")
      .between(2, 98);
  sub.option("--interval", arguments->options.interval, "Time between groups of states in `damping` [s]")
      .between(0.05, 3600.0)
      .shows_default();
  sub.option("--rounds", arguments->options.rounds, "Timed repetitions in `timing`")
      .between(1, 100000)
      .shows_default();
  sub.option("--travel", arguments->options.travel, "Length of each run of `speed` [m]")
      .between(0.01, 1000.0)
      .shows_default();
  sub.option("--seeds", arguments->options.seeds,
             "Number of seeds of `speed`; the result is their geometric mean")
      .between(1, 1000)
      .shows_default();
  sub.option("--workers", arguments->options.workers, "Numbers of workers of `speed`")
      .between(1, 100000)
      .splits_at(',')
      .shows_default();
}

}  // namespace forefeel
