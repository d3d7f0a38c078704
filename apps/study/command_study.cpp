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
#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/console/values.hpp"
#include "apps/picture/figure_files.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "apps/session/report.hpp"
#include "apps/study/study_figures.hpp"
#include "apps/study/study_folder.hpp"
#include "apps/study/study_meshes.hpp"
#include "apps/study/study_report.hpp"
#include "apps/study/study_table.hpp"
#include "geometry/common/counted.hpp"
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

nlohmann::ordered_json manifest(const std::vector<std::string>& set, const PlannedStudy& planned) {
  nlohmann::ordered_json document;
  const auto made_by = provenance(planned.scenes.front().source.hash);
  document["version"] = made_by["version"];
  document["commit"] = made_by["commit"];
  document["file"] = fs::absolute(planned.file.file).string();
  document["set"] = set;
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
  nlohmann::ordered_json before;
  std::set<std::string> listed;
  try {
    before = nlohmann::ordered_json::parse(in);
    listed = before.at("cells").get<std::set<std::string>>();
    for (const char* key : {"commit", "version", "study"}) before.at(key).get_ref<const std::string&>();
  } catch (const nlohmann::json::exception&) {  // damaged; its cells are found by their keys
    return {};
  }
  if (before["cells"] == now["cells"]) return {};
  const StudyPlan& plan = planned.plan;
  const auto same = static_cast<std::size_t>(
      std::ranges::count_if(plan.cells, [&](const StudyCell& cell) { return listed.contains(cell.key); }));
  const char* what = before["commit"] != now["commit"] || before["version"] != now["version"]
                         ? "another build of forefeel"
                     : before["study"] != now["study"] ? "another text of this study"
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
               begin_pictures(result, begin_slices(result, input.touched.space),
                              view_of(input.touched.space, options, summary.safety.force_limit)));
  const Figure figure = gantt_figure(result, options.clock.seconds, options.workers.count);
  std::vector<std::string> formats = arguments.figures.formats;
  if (std::ranges::find(formats, "svg") == formats.end()) formats.emplace_back("svg");
  const bool svg = write_figures(globals, folder, formats, {figure});
  if (globals.json) print_json(document);
  say(globals,
      fmt::format("{}: {} of {} in {} s", (folder / (svg ? "gantt.svg" : "dispatch.csv")).string(),
                  counted(result.dispatch.size(), "solve"),
                  counted(static_cast<std::size_t>(options.workers.count), "worker"), options.clock.seconds));
  return svg ? 0 : 1;
}

// ---- the study

// Counts of the cells. An incomplete study reports nothing else. left: what this command has not done of its part.
nlohmann::ordered_json counts(const StudyPlan& plan, const StudyResult& result) {
  return {{"cells", plan.cells.size()},
          {"ran", result.ran},
          {"resumed", result.resumed},
          {"left", plan.cells.size() - result.resumed - result.ran - result.of_other_parts},
          {"of_other_parts", result.of_other_parts},
          {"interrupted", result.interrupted},
          {"seconds", number(result.seconds)}};
}

void show_contrasts(const Globals& globals, const Study& study, const std::vector<Contrast>& compared) {
  std::string shown;
  for (const Contrast& c : compared) {
    const StudyMetric& metric = c.metric;
    const auto scaled = [&](double v) { return metric.ratio ? std::exp(v) : metric.scale * v; };
    if (shown != metric.key)
      say(globals, metric.title + (metric.ratio ? ", geometric mean factors:" : ", mean differences:"));
    shown = metric.key;
    const std::string where = c.slice ? fmt::format(" at {} = {}", study.axes[c.slice->axis].column,
                                                    study.axes[c.slice->axis].values[c.slice->value].text)
                                      : "";
    const char* verdict = c.verdict() == 0                               ? "not significant"
                          : (c.verdict() > 0) == metric.larger_is_better ? "better"
                                                                         : "worse";
    const auto interval = [&](const ConfidenceInterval& of) {
      return std::isfinite(of.low) && std::isfinite(of.high)
                 ? fmt::format("[{:.3g}, {:.3g}]", scaled(of.low), scaled(of.high))
                 : std::string("none");
    };
    const std::string p = std::isfinite(c.holm) ? fmt::format(", p {:.2g} (Holm)", c.holm) : "";
    // With few pairs or one trace there is no interval. Both intervals must exclude zero for a verdict.
    say(globals, fmt::format("  {} against {}{}: {}{:.3g}, bootstrap {}, Student's {}{}: {}",
                             study.axes.front().values[c.a].text, study.axes.front().values[c.b].text, where,
                             metric.ratio ? "×" : "", scaled(c.comparison.bootstrap.mean),
                             interval(c.comparison.bootstrap), interval(c.comparison.student), p, verdict));
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
  say(globals, fmt::format("{} (means over cells)", fmt::join(device_titles(), " | ")));
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

// Claims the folder of the results.
void begin_folder(const Globals& globals, const PlannedStudy& planned, const StudyArguments& arguments,
                  const nlohmann::ordered_json& now) {
  const fs::path folder = arguments.output;
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw InputError(arguments.output, "is a file, expected a folder for the results");
  if (const auto change = change_since(folder, planned, now)) warn(globals, *change);
  claim_folder(folder, {"study.json", "cells.csv", "report.html"});
  if (!arguments.figures.formats.empty()) figures_in(folder);
  check_writable(folder / "cells.csv");
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

// Tables and report are written only when all cells are done. Returns the exit code.
int tell_incomplete(const Globals& globals, const PlannedStudy& planned, const StudyResult& result,
                    const StudyArguments& arguments) {
  const std::size_t all = planned.plan.cells.size(), done = result.resumed + result.ran;
  const std::size_t own = all - result.of_other_parts;
  if (result.interrupted)
    warn(globals, fmt::format("interrupted after {} of {}, {} left; the same command resumes", done,
                              counted(own, "cell"), own - done));
  else if (arguments.part.empty())
    warn(globals,
         fmt::format("{} of {} cells are in none of these folders; forefeel study {} -o {} runs them",
                     all - done, all, planned.file.file.string(), arguments.output));
  else
    say(globals, fmt::format("{}: the {} of part {}, {} run in {:.1f} s; when all parts are done, forefeel "
                             "study --merge {} … -o DIR compares them",
                             arguments.output, counted(own, "cell"), arguments.part, result.ran,
                             result.seconds, arguments.output));
  if (globals.json) {
    nlohmann::ordered_json document = counts(planned.plan, result);
    document["files"] = nlohmann::ordered_json::array();
    document["provenance"] = provenance(planned.scenes.front().source.hash);
    print_json(document);
  }
  return result.interrupted || arguments.part.empty() ? 1 : 0;
}

struct AskedStudy {
  std::string file;
  std::vector<std::string> set;
};

// The study that is named, or else that of the first folder to be merged.
AskedStudy study_of(const Globals& globals, const StudyArguments& arguments) {
  if (!arguments.study.empty()) return {arguments.study, globals.set};
  if (arguments.merged.empty()) throw InputError("study", "no study given, expected STUDY.toml");
  if (!globals.set.empty())
    throw InputError("--set", "has no effect on cells that are there, expected it without --merge");
  std::ifstream in(fs::path(arguments.merged.front()) / "study.json");
  try {
    const auto made_by = nlohmann::ordered_json::parse(in);
    return {made_by.at("file").get<std::string>(), made_by.at("set").get<std::vector<std::string>>()};
  } catch (const nlohmann::json::exception&) {
    throw InputError(
        "--merge " + arguments.merged.front(),
        "holds no sound study.json, expected the folder of a study, or STUDY.toml beside --merge");
  }
}

void check_arguments(const Globals& globals, const StudyArguments& arguments) {
  if (globals.seed != 0) throw InputError("--seed", "a study lists its seeds, expected them in the file");
  if (arguments.output.empty()) throw InputError("--output", "is empty, expected a folder");
  if (!arguments.part.empty() + !arguments.merged.empty() + (arguments.gantt > 0) > 1)
    throw InputError("study", "--part, --merge and --gantt are three ways to begin, expected one of them");
}

int run_command(const Globals& globals, const StudyArguments& arguments) {
  check_arguments(globals, arguments);
  take_figures(arguments.figures);
  const StudyPart part = arguments.merged.empty() ? part_of(arguments.part) : StudyPart{.number = 0, .of = 1};
  const AskedStudy asked = study_of(globals, arguments);
  const PlannedStudy planned = plan_study(read_study(asked.file, asked.set), globals);
  const StudyPlan& plan = planned.plan;
  for (const std::string& warning : planned.warnings) warn(globals, warning);
  end_if_interrupted("any cell was run");
  if (arguments.gantt > 0) return run_gantt(globals, planned, arguments);

  const fs::path folder = arguments.output;
  check_parts(arguments.merged, plan);
  const nlohmann::ordered_json now = manifest(asked.set, planned);
  begin_folder(globals, planned, arguments, now);
  StudyResult result =
      run_study_in({folder, arguments.merged, json_text(now, 1) + "\n"}, part, plan, globals);
  if (!arguments.merged.empty()) result.of_other_parts = 0;  // nobody else runs what is missing
  if (result.resumed + result.ran < plan.cells.size())
    return tell_incomplete(globals, planned, result, arguments);
  if (const auto missed = loads_missed(plan, result.cells)) warn(globals, *missed);
  add_regret(plan.study, result.cells);
  const MeshFindings meshes = measure_meshes(globals, planned, result.cells);
  const std::vector<AxisRanking> ranked = rankings(plan.study, result.cells);
  std::vector<Contrast> compared;
  for (const StudyMetric& metric : compared_metrics(plan.study))
    std::ranges::move(contrasts(plan.study, result.cells, metric), std::back_inserter(compared));
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
  say(globals, fmt::format("{}: {}, {} run in {:.1f} s, {} there before", (folder / "report.html").string(),
                           counted(plan.cells.size(), "cell"), result.ran, result.seconds, result.resumed));
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
  sub.option("--merge", arguments->merged,
             "Compare the finished cells of these folders, as of parts. None is run; STUDY is theirs unless "
             "given")
      .shows("DIR/...");
}

}  // namespace forefeel
