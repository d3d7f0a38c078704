// forefeel study STUDY.toml -o DIR/: runs every combination of the varied keys with every seed. Writes a
// table, a ranking and a report.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "apps/session/report.hpp"
#include "apps/study/study_figures.hpp"
#include "apps/study/study_folder.hpp"
#include "apps/study/study_gantt.hpp"
#include "apps/study/study_meshes.hpp"
#include "apps/study/study_report.hpp"
#include "apps/study/study_table.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/result_folder.hpp"
#include "scheduling/record/run_files.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

struct StudyArguments {
  std::string study, output;
  std::size_t gantt = 0;  // row of cells.csv, from 1; 0: none
  FigureArguments figures;
  std::string part;                 // K/N; empty: all cells
  std::vector<std::string> merged;  // folders of other parts
};

nlohmann::ordered_json manifest(const Globals& globals, const PlannedStudy& planned) {
  nlohmann::ordered_json document;
  const auto made_by = provenance(planned.scenes.front().source.hash);
  document["version"] = made_by["version"];
  document["commit"] = made_by["commit"];
  document["file"] = fs::absolute(planned.file.file).string();
  document["set"] = globals.set;
  document["study"] = planned.file.text;
  document["cells"] = nlohmann::ordered_json::array();
  for (const StudyCell& cell : planned.plan.cells) document["cells"].push_back(cell.key);
  return document;
}

// One line about what changed since DIR/ was started, or nothing.
std::optional<std::string> change_since(const fs::path& folder, const PlannedStudy& planned,
                                        const nlohmann::ordered_json& now) {
  std::ifstream in(folder / "study.json");
  if (!in) return {};
  const auto before = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!before.is_object() || !before.contains("cells") || before["cells"] == now["cells"]) return {};
  const StudyPlan& plan = planned.plan;
  const auto listed = before["cells"].get<std::set<std::string>>();
  const auto same = static_cast<std::size_t>(
      std::ranges::count_if(plan.cells, [&](const StudyCell& cell) { return listed.contains(cell.key); }));
  const char* what =
      before.value("commit", "") != now["commit"] || before.value("version", "") != now["version"]
          ? "another build of forefeel"
      : before.value("study", "") != now["study"] ? "another text of this study"
                                                  : "another scene, trace or --set";
  return fmt::format(
      "{}: begun with {}; {} of its {} cells are the same and kept, {} are new, {} are no longer part",
      folder.string(), what, same, listed.size(), plan.cells.size() - same,
      listed.size() - std::min(same, listed.size()));
}

// ---- a dispatch Gantt

// Reruns the cell, which gives the same session, and writes its files and picture.
int run_gantt(const Globals& globals, const PlannedStudy& planned, const StudyArguments& arguments) {
  const StudyPlan& plan = planned.plan;
  if (arguments.gantt > plan.cells.size())
    throw InputError("--gantt", fmt::format("is {}, expected a row of cells.csv from 1 to {}",
                                            arguments.gantt, plan.cells.size()));
  if (plan.study.sustained)
    throw InputError("--gantt", "a cell of a sustained-speed study is many sessions, expected another study");
  StudyCell cell = plan.cells[arguments.gantt - 1];
  const Scene& scene = planned.scenes[cell.input];
  const SessionInput& input = plan.inputs[cell.input];
  cell.options.workers.threads = globals.threads;
  const SessionOptions options = with_load_found(cell, input).options;
  const fs::path folder = fs::path(arguments.output) / fmt::format("cell-{:04}", arguments.gantt);
  claim_folder(folder, {"frames.csv", "dispatch.csv", "switches.csv", "summary.json", "report.html",
                        "gantt.svg", "gantt.png", "gantt.pdf"});
  Progress progress(globals, "session");
  const SessionPlan session = make_plan(input, options);
  const SessionResult result =
      run_session(session, {.progress = [&](const SessionProgress& p) {
                    progress.show(p.seconds > 0 ? std::min(1.0, p.t / p.seconds) : 0.0, phase_in_words(p));
                  }});
  write_run_files(folder, result, options);
  SessionSummary summary = summarise(result, session);
  const MeshError by_mesh = MeshErrorTask(scene, MeshErrorTask::When::at_the_end).get();
  summary.error.mesh = {by_mesh.error, by_mesh.positions, measured_by(by_mesh), by_mesh.low, by_mesh.high};
  nlohmann::ordered_json document = to_json(summary);
  document["provenance"] = provenance(scene.source.hash);
  write_whole(folder / "summary.json", json_text(document, 2) + "\n");
  write_report(folder, summary, document, scene,
               begin_pictures(result, begin_slices(result, scene.space),
                              view_of(scene.space, options, summary.safety.force_limit)));
  const Figure figure = gantt_figure(result, options.clock.seconds, options.workers.count);
  std::vector<std::string> formats = arguments.figures.formats;
  if (std::ranges::find(formats, "svg") == formats.end()) formats.emplace_back("svg");
  const bool svg = write_figures(globals, folder, formats, {figure});
  if (globals.json) print_json(document);
  say(globals, fmt::format("{}: {} solves of {} workers in {} s",
                           (folder / (svg ? "gantt.svg" : "dispatch.csv")).string(), result.dispatch.size(),
                           options.workers.count, options.clock.seconds));
  return svg ? 0 : 1;
}

// ---- the study

// Counts of the cells. An interrupted study reports nothing else.
nlohmann::ordered_json counts(const StudyPlan& plan, const StudyResult& result) {
  return {{"cells", plan.cells.size()},        {"ran", result.ran},
          {"resumed", result.resumed},         {"left", plan.cells.size() - result.resumed - result.ran},
          {"interrupted", result.interrupted}, {"seconds", number(result.seconds)}};
}

void show_contrasts(const Globals& globals, const Study& study, const std::vector<Contrast>& compared) {
  std::string shown;
  for (const Contrast& c : compared) {
    const StudyMetric& metric = c.metric;
    const auto scaled = [&](double v) { return metric.ratio ? std::exp(v) : metric.scale * v; };
    if (shown != metric.key) say(globals, metric.title + (metric.ratio ? ", factors:" : ", differences:"));
    shown = metric.key;
    const std::string where = c.slice ? fmt::format(" at {} = {}", study.axes[c.slice->axis].column,
                                                    study.axes[c.slice->axis].values[c.slice->value].text)
                                      : "";
    const char* verdict = c.comparison.verdict() == 0                               ? "not significant"
                          : (c.comparison.verdict() > 0) == metric.larger_is_better ? "better"
                                                                                    : "worse";
    const auto interval = [&](const ConfidenceInterval& of) {
      return std::isfinite(of.low) && std::isfinite(of.high)
                 ? fmt::format("[{:.3g}, {:.3g}]", scaled(of.low), scaled(of.high))
                 : std::string("none");
    };
    // With few pairs or one trace there is no interval. Both intervals must exclude zero for a verdict.
    say(globals, fmt::format("  {} against {}{}: {}{:.3g}, bootstrap {}, Student's {}: {}",
                             study.axes.front().values[c.a].text, study.axes.front().values[c.b].text, where,
                             metric.ratio ? "×" : "", scaled(c.comparison.bootstrap.mean),
                             interval(c.comparison.bootstrap), interval(c.comparison.student), verdict));
  }
}

// The devices behind the figures, and the result in one sentence.
struct Findings {
  MeshFindings meshes;
  std::vector<StudyDevice> devices;
  std::optional<std::string> verdict;
  std::vector<std::string> advice;
};

std::vector<std::string> attention(const Findings& found) {
  std::vector<std::string> lines = found.meshes.above;
  for (const std::string& line : attention(found.devices)) lines.push_back(line);
  return lines;
}

void tell(const Globals& globals, const Findings& found) {
  for (const std::string& line : attention(found)) say(globals, "attention: " + line);
  for (const std::string& line : found.meshes.others) say(globals, line);
  if (found.verdict) say(globals, *found.verdict);
  for (const std::string& line : found.advice) say(globals, line);
  say(globals, fmt::format("{}", fmt::join(device_titles(), " | ")));
  for (const StudyDevice& device : found.devices)
    say(globals, fmt::format("  {}", fmt::join(device_row(device), " | ")));
}

// The devices and the verdict come first, because the other values must be read with them in mind.
nlohmann::ordered_json document_of(const Findings& found) {
  return {{"attention", attention(found)},
          {"discretisation", found.meshes.others},
          {"verdict", found.verdict ? nlohmann::ordered_json(*found.verdict) : nlohmann::ordered_json()},
          {"advice", found.advice},
          {"devices", devices_json(found.devices)}};
}

// Claims the folder of the results, and writes study.json.
void begin_folder(const Globals& globals, const PlannedStudy& planned, const StudyArguments& arguments) {
  const fs::path folder = arguments.output;
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw InputError(arguments.output, "is a file, expected a folder for the results");
  const nlohmann::ordered_json now = manifest(globals, planned);
  if (const auto change = change_since(folder, planned, now)) warn(globals, *change);
  claim_folder(folder, {"study.json", "cells.csv", "report.html"});
  if (!arguments.figures.formats.empty()) figures_in(folder);
  check_writable(folder / "cells.csv");
  write_whole(folder / "study.json", json_text(now, 1) + "\n");
}

// K/N in words of StudyPart. All cells if it is empty.
StudyPart part_of(const std::string& text) {
  if (text.empty()) return {};
  StudyPart part{.number = 0, .of = 0};
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, part.number);
  if (number.ec == std::errc() && number.ptr != end && *number.ptr == '/') {
    const auto of = std::from_chars(number.ptr + 1, end, part.of);
    if (of.ec == std::errc() && of.ptr == end && part.number >= 1 && part.number <= part.of) return part;
  }
  throw InputError("--part", fmt::format("is '{}', expected K/N with 1 <= K <= N, as 2/8", text));
}

// Tables and report are written only when all cells are done.
void tell_incomplete(const Globals& globals, const PlannedStudy& planned, const StudyResult& result,
                     const StudyArguments& arguments) {
  const std::size_t done = result.resumed + result.ran, all = planned.plan.cells.size();
  if (result.interrupted)
    warn(globals, fmt::format("interrupted after {} of {} cells, {} left; the same command resumes", done,
                              all, all - done));
  else
    say(globals,
        fmt::format(
            "{}: {} of {} cells, {} run in {:.1f} s; when all parts are done, forefeel study --merge {} … -o "
            "DIR compares them",
            arguments.output, done, all, result.ran, result.seconds, arguments.output));
  if (!globals.json) return;
  nlohmann::ordered_json document = counts(planned.plan, result);
  document["files"] = nlohmann::ordered_json::array();
  document["provenance"] = provenance(planned.scenes.front().source.hash);
  print_json(document);
}

// The study that is named, or else that of the first folder to be merged.
StudyFile study_of(const Globals& globals, const StudyArguments& arguments) {
  if (!arguments.study.empty()) return read_study(arguments.study, globals.set);
  if (arguments.merged.empty()) throw InputError("study", "no study given, expected STUDY.toml");
  const fs::path file = fs::path(arguments.merged.front()) / "study.json";
  std::ifstream in(file);
  const auto made_by = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!made_by.is_object() || !made_by.contains("file") || !made_by["file"].is_string() ||
      !made_by.contains("set") || !made_by["set"].is_array())
    throw InputError("--merge " + arguments.merged.front(),
                     "holds no study.json, expected the folder of a study");
  return read_study(made_by["file"].get<std::string>(), made_by["set"].get<std::vector<std::string>>());
}

int run_command(const Globals& globals, const StudyArguments& arguments) {
  if (globals.seed != 0) throw InputError("--seed", "a study lists its seeds, expected them in the file");
  if (arguments.output.empty()) throw InputError("--output", "is empty, expected a folder");
  take_figures(arguments.figures);
  const StudyPart part = part_of(arguments.part);
  const PlannedStudy planned = plan_study(study_of(globals, arguments));
  const StudyPlan& plan = planned.plan;
  for (const std::string& warning : planned.warnings) warn(globals, warning);
  end_if_interrupted("any cell was run");
  if (arguments.gantt > 0) return run_gantt(globals, planned, arguments);

  const fs::path folder = arguments.output;
  check_parts(arguments.merged, plan);
  begin_folder(globals, planned, arguments);
  StudyResult result = run_study_in({folder, arguments.merged}, part, plan, globals);
  if (result.interrupted || result.of_other_parts > 0) {
    tell_incomplete(globals, planned, result, arguments);
    return result.interrupted ? 1 : 0;
  }
  if (const auto missed = loads_missed(plan, result.cells)) warn(globals, *missed);
  add_regret(plan.study, result.cells);
  const MeshFindings meshes = measure_meshes(globals, planned, result.cells);
  const std::vector<AxisRanking> ranked = rankings(plan.study, result.cells);
  std::vector<Contrast> compared = contrasts(plan.study, result.cells, primary_metric(plan.study));
  for (Contrast& c : contrasts(plan.study, result.cells, second_metric(plan.study)))
    compared.push_back(std::move(c));
  const Findings found{.meshes = meshes,
                       .devices = study_devices(plan, result.cells),
                       .verdict = study_verdict(plan.study, result.cells),
                       .advice = study_advice(plan.study, result.cells)};
  write_whole(folder / "cells.csv", cells_csv(plan.study, result.cells));
  const Palette& palette = palette_in_use();
  write_whole(folder / "report.html", study_page(planned, result, ranked, compared, meshes.lines(), palette));
  const bool drawn = arguments.figures.formats.empty() ||
                     write_figures(globals, figures_in(folder), arguments.figures.formats,
                                   study_figures(plan.study, result.cells, ranked, palette));

  if (globals.json) {
    nlohmann::ordered_json document = counts(plan, result);
    document.update(document_of(found));
    document.update(ranking_json(plan.study, ranked, compared));
    document["notes"] = notes_of(result.cells);
    document["files"] = {(folder / "cells.csv").string(), (folder / "report.html").string()};
    document["provenance"] = provenance(planned.scenes.front().source.hash);
    print_json(document);
  }
  tell(globals, found);
  show_contrasts(globals, plan.study, compared);
  for (const std::string& note : sustained_notes(plan.study, result.cells)) say(globals, note);
  for (const std::string& note : notes_of(result.cells)) say(globals, note);
  say(globals,
      fmt::format("{}: {} cells, {} run in {:.1f} s, {} there before", (folder / "report.html").string(),
                  plan.cells.size(), result.ran, result.seconds, result.resumed));
  return drawn ? 0 : 1;
}

}  // namespace

void add_study(CommandLine& line) {
  const auto arguments = std::make_shared<StudyArguments>();
  Command sub = line.add(
      "study",
      "Run every combination of policies, devices, models …, and compare them: table, ranking, report");
  sub.runs([arguments](const Globals& globals) { return run_command(globals, *arguments); });
  sub.option(
      "STUDY", arguments->study,
      "Study (TOML). target_load = [L, …] in [vary] chooses the cost of a solve: the motion then needs L "
      "times as many new states per second as the workers solve, messages included. A session ends with "
      "its motion, or after session.seconds of the study if that is earlier");
  sub.option("-o,--output", arguments->output, "Folder of the results; resumed if it exists")
      .required()
      .shows("DIR/");
  sub.option("--gantt", arguments->gantt,
             "Only run this cell again (a row of cells.csv, counted from 1) and draw when each worker solved "
             "what")
      .check(above_zero)
      .shows("CELL");
  add_figures(sub, arguments->figures, "DIR/figures");
  sub.option("--part", arguments->part,
             "Only run every N-th cell from the K-th on, into a folder of its own: parts of a study on many "
             "machines")
      .shows("K/N");
  sub.option(
         "--merge", arguments->merged,
         "Take the finished cells of these folders, as of parts; STUDY is then theirs and need not be given")
      .shows("DIR/...");
}

}  // namespace forefeel
