#include "apps/study/planned_study.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_declared.hpp"
#include "apps/scene/scene_session.hpp"
#include "apps/scene/toml_text.hpp"
#include "geometry/common/scanner.hpp"
#include "geometry/common/sha256.hpp"
#include "scheduling/motion/trace.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr int format_version = 3;  // of a cell's record; raised when the content of the record changes

// The file of a trace, by the rules of the device; empty for other devices.
fs::path trace_file(const DeviceSpec& device, const fs::path& folder) {
  const TraceMotion* trace = std::get_if<TraceMotion>(&device.motion());
  return trace ? found_from(folder, trace->file) : fs::path();
}

// A scene has [model] select or [session] select, never both. An override goes into the section that the
// scene uses.
std::vector<std::string> with_select_of(const fs::path& scene, std::vector<std::string> overrides) {
  bool in_model = false;
  try {
    const std::string text = read_text_file(scene);
    check_key_depth(text, scene);
    in_model = toml::parse(text)["model"]["select"].is_string();
  } catch (const toml::parse_error&) {  // load_scene reports the error
  }
  for (std::string& text : overrides)
    if (in_model && text.starts_with("session.select=")) text.replace(0, 7, "model");
  return overrides;
}

// The error about an overridden scene key, with the place in the study that gave the key.
InputError located(const StudyFile& study, const InputError& error) {
  if (error.place().option.empty()) return error;
  for (std::string path = error.place().key;;) {
    if (const auto found = study.origin.find(path); found != study.origin.end())
      return {found->second, error.problem()};
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return error;
    path.resize(dot);
  }
}

Scene load_combination(const StudyFile& study, std::span<const std::size_t> choice, const Scene* like) {
  const fs::path& scene = study.scene_of(choice);
  std::vector<std::string> overrides = with_select_of(scene, study.overrides(choice));
  overrides.push_back("session.clock=\"virtual\"");
  try {
    return load_scene_with_sites(scene, overrides, {}, like);
  } catch (const InputError& error) {
    throw located(study, error);
  }
}

InputPlace axis_place(const StudyFile& study, const std::string& column) {
  for (const StudyFileAxis& axis : study.axes)
    if (axis.column == column) return axis.where;
  return {.file = study.file.string()};
}

// The place where the study gives a key, or else the scene.
InputPlace place_of(const StudyFile& study, const Scene& scene, const std::string& key) {
  for (std::string path = key;;) {
    if (const auto found = study.origin.find(path); found != study.origin.end()) return found->second;
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) break;
    path.resize(dot);
  }
  const std::pair<const char*, const InputPlace&> places[] = {
      {"session.device", scene.written.device_place},
      {"session.cost", scene.written.cost_place},
      {"session.arrivals", scene.written.arrivals_place},
      {"state_space.box", scene.written.box_place}};
  for (const auto& [known, place] : places)
    if (key == known && !place.empty() && place != InputPlace{.file = scene.source.file.string(), .key = key})
      return place;
  InputPlace nowhere = study.scene_place;  // for a key that neither gives
  nowhere.key += ": " + scene.source.file.string() + ": " + key;
  return nowhere;
}

// An error in a motion may come from the study: from its speed, or from its changes of the body or the box.
InputPlace place_of_device(const StudyFile& study, const Scene& scene, const std::string& problem) {
  if (problem.starts_with("speed "))
    for (const StudyFileAxis& axis : study.axes)
      if (axis.column == "speed") return axis.where;
  if (problem.starts_with("speed ") && study.sustained) return study.sustained_place;
  if (!study.origin.contains("session.device"))
    for (const char* key : {"body.length", "state_space.box"})
      if (const auto found = study.origin.find(key); found != study.origin.end()) return found->second;
  return place_of(study, scene, "session.device");
}

// Checks what a session would refuse; the error names the place that gave the value.
InputError placed(const StudyFile& study, const Scene& scene, const SessionOptions& options,
                  const InputError& error) {
  const std::string &key = error.place().key, &problem = error.problem(), whole = error.what();
  const bool of_file = !error.place().file.empty();
  if (key == "study.sustained") return {study.sustained_place, problem};
  for (const std::string column : {"speed", "target_load"})
    if (key == "study." + column) return {axis_place(study, column), problem};
  for (const char* section : {"session.", "model.", "state_space."}) {
    if (of_file || !key.starts_with(section)) continue;
    const InputPlace place = place_of(study, scene, key);
    const bool named = place.key.ends_with(key) || place.key.ends_with(key.substr(key.rfind('.')));
    return {place, named ? problem : fmt::format("{} {}", key, problem)};
  }
  if (!of_file && key == "cost") return {place_of(study, scene, "session.cost"), whole};
  if (options.planning.arrivals && error.place().file == options.planning.arrivals->string())
    return {place_of(study, scene, "session.arrivals"), whole};
  return {place_of_device(study, scene, problem), whole};
}

// If states arrive at given times, nothing is solved, so a study that varies how to solve compares nothing:
// an error. If the study gives the arrivals, keys of solving in the scene are ignored with a warning.
void check_arrivals(const StudyFile& study, const Scene& scene, const SessionOptions& options,
                    std::vector<std::string>& warnings) {
  if (!options.planning.arrivals) return;
  const std::string arrivals = place_of(study, scene, "session.arrivals").text();
  const auto refuse = [&](const InputPlace& place) { throw InputError(place, no_effect_beside(arrivals)); };
  if (study.sustained) refuse(study.sustained_place);
  for (const StudyFileAxis& axis : study.axes)
    if (axis.column == "target_load") refuse(axis.where);
  std::string passed_over;
  for (const auto& [key, where] : scene.written.scheduling) {
    if (!where.option.empty()) refuse(place_of(study, scene, key));  // by the study
    passed_over += (passed_over.empty() ? "" : ", ") + where.text();
  }
  if (passed_over.empty()) return;
  const std::string warning =
      fmt::format("{}: without effect where states arrive at given times ({})", passed_over, arrivals);
  if (std::ranges::find(warnings, warning) == warnings.end()) warnings.push_back(warning);
}

// Key of a cell's stored result: the SHA-256 of everything that it depends on. content: identifies the session's body
// and options, as a scene's hash does.
std::string cell_key(const std::string& content, const StudyCell& cell, const SessionInput& input,
                     const std::optional<SustainedOptions>& sustained) {
  const SessionOptions& options = cell.options;
  const auto made_by = provenance("");
  Sha256 hash;
  hash.add(fmt::format("{}\n{}\n{}\n", format_version, made_by["version"].get<std::string>(),
                       made_by["commit"].get<std::string>()));
  hash.add(content + "\n");
  hash.add(fmt::format("{}\n{}\n{}\n{}\n", to_text(options.motion.device), to_text(options.workers.cost),
                       options.seed, options.clock.seconds));
  if (const fs::path trace = trace_file(options.motion.device, input.files.scene); !trace.empty())
    hash.add(read_text_file(trace));
  if (options.planning.arrivals) hash.add(read_text_file(*options.planning.arrivals));
  if (const auto& s = sustained)
    hash.add(fmt::format("sustained {} {} {} {} {}\n", s->travel, s->share, s->tolerance, s->low, s->high));
  return hash.hex();
}

StudyCell planned_cell(const PlannedStudy& planned, std::size_t combination, std::uint64_t seed,
                       const SessionInput& input, std::vector<std::string>& warnings) {
  const StudyFile& file = planned.file;
  const Study& study = planned.plan.study;
  const Scene& scene = planned.scenes[combination];
  const auto at_its_place = [&](const auto& step) {
    try {
      step();
    } catch (const InputError& error) {
      throw placed(file, scene, scene.session, error);
    }
  };
  StudyCell cell;
  at_its_place([&] { cell = make_cell(study, combination, seed, session_options(scene)); });
  check_arrivals(file, scene, cell.options, warnings);
  // A trace has its own length, unless the study itself says another.
  if (std::holds_alternative<TraceMotion>(cell.options.motion.device.motion()) &&
      !file.origin.contains("session.seconds") && !file.origin.contains("session"))
    cell.options.clock.length = RunLength::motion;
  at_its_place([&] {
    check_cell(study, input, cell);
    set_cost(study, input, cell);
  });
  for (const std::string& note : cell.notes)
    if (std::ranges::find(warnings, note) == warnings.end()) warnings.push_back(note);
  cell.key = cell_key(scene.source.hash, cell, input, study.sustained);
  return cell;
}

}  // namespace

PlannedStudy plan_study(StudyFile given, const Globals& globals) {
  PlannedStudy planned{.file = std::move(given), .scenes = {}, .plan = {}, .warnings = {}};
  const StudyFile& file = planned.file;
  StudyPlan& plan = planned.plan;
  plan.study = file.study();
  planned.scenes.reserve(plan.study.combinations());  // `like` points into it
  for (std::size_t c = 0; c < plan.study.combinations(); ++c) {
    end_if_interrupted("any cell was run");
    const Scene* like = planned.scenes.empty() ? nullptr : &planned.scenes.back();
    planned.scenes.push_back(load_combination(file, plan.study.choice(c), like));
    const Scene& scene = planned.scenes.back();
    if (c == 0) planned.warnings = scene.source.warnings;
    SessionInput input = session_input(scene);
    touch_anywhere(scene, globals, input,
                   like && like->source.body == scene.source.body ? &plan.inputs.back() : nullptr);
    for (const std::uint64_t seed : file.seeds)
      plan.cells.push_back(planned_cell(planned, c, seed, input, planned.warnings));
    plan.inputs.push_back(input);
  }
  return planned;
}

}  // namespace forefeel
