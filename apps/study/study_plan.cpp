#include "apps/study/study_plan.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene_input/sha256.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/record/needed_states.hpp"
#include "scheduling/workers/cost.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr int format_version = 1;  // of a cell's record: raised when what is kept of a cell changes

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// The file behind trace:FILE, found as the device finds it; empty for other devices.
fs::path trace_file(const std::string& device, const fs::path& folder) {
  if (!device.starts_with("trace:")) return {};
  const fs::path name =
      device.substr(6, device.find(',') == std::string::npos ? std::string::npos : device.find(',') - 6);
  return fs::exists(folder / name) ? folder / name : name;
}

// The scene says [model] select or [session] select, never both: an override takes the place the scene uses.
std::vector<std::string> with_select_of(const Study& study, std::vector<std::string> overrides) {
  bool in_model = false;
  try {
    in_model = toml::parse_file(study.scene.string())["model"]["select"].is_string();
  } catch (const toml::parse_error&) {  // load_scene says what is wrong
  }
  for (std::string& text : overrides)
    if (in_model && text.starts_with("session.select=")) text.replace(0, 7, "model");
  return overrides;
}

Scene load_combination(const Study& study, std::span<const std::size_t> choice, const Scene* like) {
  std::vector<std::string> overrides = with_select_of(study, study.overrides(choice));
  overrides.push_back("session.clock=\"virtual\"");
  try {
    return load_scene(study.scene, overrides, like);
  } catch (const InputError& error) {
    throw located(study, error);
  }
}

std::optional<double> number_of(const Study& study, std::span<const std::size_t> choice,
                                const std::string& column) {
  for (std::size_t i = 0; i < study.axes.size(); ++i)
    if (study.axes[i].column == column) return study.axes[i].values[choice[i]].number;
  return {};
}

InputPlace axis_place(const Study& study, const std::string& column) {
  for (const StudyAxis& axis : study.axes)
    if (axis.column == column) return axis.where;
  return {.file = study.file.string()};
}

// Where the study, or else the scene, gives a key.
InputPlace place_of(const Study& study, const Scene& scene, const std::string& key) {
  for (std::string path = key;;) {
    if (const auto found = study.origin.find(path); found != study.origin.end()) return found->second;
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) break;
    path.resize(dot);
  }
  const std::pair<const char*, const InputPlace&> places[] = {{"session.device", scene.device_place},
                                                              {"session.cost", scene.cost_place},
                                                              {"session.arrivals", scene.arrivals_place},
                                                              {"state_space.box", scene.box_place}};
  for (const auto& [known, place] : places)
    if (key == known && !place.empty() && place != InputPlace{.file = scene.file.string(), .key = key})
      return place;
  InputPlace nowhere = study.scene_place;  // neither gives it
  nowhere.key += ": " + scene.file.string() + ": " + key;
  return nowhere;
}

// What is wrong with a motion may come from the speed that the study gives, or from the body and the box that it changes.
InputPlace place_of_device(const Study& study, const Scene& scene, const std::string& problem) {
  if (problem.starts_with("speed "))
    for (const StudyAxis& axis : study.axes)
      if (axis.column == "speed") return axis.where;
  if (problem.starts_with("speed ") && study.sustained) return study.sustained_place;
  if (!study.origin.contains("session.device"))
    for (const char* key : {"body.length", "state_space.box"})
      if (const auto found = study.origin.find(key); found != study.origin.end()) return found->second;
  return place_of(study, scene, "session.device");
}

// What a session would refuse, said with the place that gave it.
InputError placed(const Study& study, const Scene& scene, const SessionOptions& options,
                  const InputError& error) {
  const std::string &key = error.place().key, &problem = error.problem(), whole = error.what();
  const bool of_file = !error.place().file.empty();
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

// All that a session refuses, by its own check.
void check_cell(const Study& study, const Scene& scene, const SessionInput& input, SessionOptions options) {
  const std::string device = options.motion.device;
  const auto check = [&] {
    try {
      check_session(input, options);
    } catch (const InputError& error) {
      throw placed(study, scene, options, error);
    }
  };
  if (!study.sustained) return check();
  for (const double speed : {study.sustained->low, study.sustained->high}) {
    options.motion.device = device_at_speed(device, speed, study.sustained_place);
    options.clock.seconds = study.sustained->travel / speed;
    check();
  }
}

// Where states arrive at given times nothing is solved: who says how compares nothing. What the scene says for other runs is
// passed over with a warning where the study brings the arrivals.
void check_arrivals(const Study& study, const Scene& scene, const SessionOptions& options,
                    std::vector<std::string>& warnings) {
  if (!options.planning.arrivals) return;
  const std::string arrivals = place_of(study, scene, "session.arrivals").text();
  const auto refuse = [&](const InputPlace& place) { throw InputError(place, no_effect_beside(arrivals)); };
  if (study.sustained) refuse(study.sustained_place);
  for (const StudyAxis& axis : study.axes)
    if (axis.column == "target_load") refuse(axis.where);
  std::string passed_over;
  for (const auto& [key, where] : scene.scheduling) {
    if (!where.option.empty()) refuse(place_of(study, scene, key));  // by the study
    passed_over += (passed_over.empty() ? "" : ", ") + where.text();
  }
  if (passed_over.empty()) return;
  const std::string warning =
      fmt::format("{}: without effect where states arrive at given times ({})", passed_over, arrivals);
  if (std::ranges::find(warnings, warning) == warnings.end()) warnings.push_back(warning);
}

std::string key_of(const Scene& scene, const SessionOptions& options, const Study& study) {
  Sha256 hash;
  const auto made_by = provenance("");
  hash.add(fmt::format("{}\n{}\n{}\n", format_version, made_by["version"].get<std::string>(),
                       made_by["commit"].get<std::string>()));
  hash.add(scene.hash + "\n");
  hash.add(fmt::format("{}\n{}\n{}\n{}\n", options.motion.device, options.workers.cost, options.seed,
                       options.clock.seconds));
  if (const fs::path trace = trace_file(options.motion.device, scene.file.parent_path()); !trace.empty())
    hash.add(contents(trace));
  if (options.planning.arrivals) hash.add(contents(*options.planning.arrivals));
  if (const auto& s = study.sustained)
    hash.add(fmt::format("sustained {} {} {} {} {}\n", s->travel, s->share, s->tolerance, s->low, s->high));
  return hash.hex();
}

}  // namespace

double states_needed_per_second(const Scene& scene, const SessionOptions& options) {
  const auto device = make_device(options.motion.device, {.box = scene.space.box,
                                                          .inward = scene.inward,
                                                          .seed = options.seed,
                                                          .folder = scene.file.parent_path()});
  const double h = visit_cell(options.judging, scene.space.spacing);
  const auto frames = static_cast<std::size_t>(std::llround(options.clock.seconds / options.clock.frame));
  NeededStates needed(scene.space.box, h);
  if (options.planning.rest_known) needed.know(Vec3::Zero());
  for (std::size_t k = 0; k < frames; ++k)
    needed.visit(device->position(static_cast<double>(k) * options.clock.frame, Vec3::Zero()));
  return static_cast<double>(needed.count()) / options.clock.seconds;
}

std::string cost_for_load(double load, const SessionOptions& options, double demand,
                          const InputPlace& where) {
  const double sigma =
      std::log(10.0) / (2 * 1.959964);  // 95 % within a factor of ten, as the paper's 0.1 to 1 s
  const double batch = std::max(options.planning.batch, 1);
  const double job = load * options.workers.count * batch / demand;
  const double mean = (job - 2 * options.workers.latency) / (1 + (batch - 1) * options.workers.batch_share);
  if (!(mean > 0))
    throw InputError(
        where,
        fmt::format("holds {}, but a message of {} s each way alone makes the load {:.3g}; expected more",
                    load, options.workers.latency,
                    2 * options.workers.latency * demand / (options.workers.count * batch)));
  if (mean > 1e6)
    throw InputError(
        where, fmt::format("holds {}, for which a solve takes {:.3g} s; expected a load of at most {:.3g}",
                           load, mean, load * 1e6 / mean));
  return fmt::format("lognormal:{},{}", mean * std::exp(-0.5 * sigma * sigma), sigma);
}

std::string device_at_speed(const std::string& device, double speed, const InputPlace& where) {
  if (!device.starts_with("path:"))
    throw InputError(where, fmt::format("device '{}' has no speed to set, expected path:NAME", device));
  if (device.find("speed=") != std::string::npos)
    throw InputError(where, fmt::format("device '{}' names its speed already, expected it once", device));
  return fmt::format("{},speed={}", device, speed);
}

StudyPlan plan_study(Study given) {
  StudyPlan plan{.study = std::move(given), .scenes = {}, .cells = {}, .warnings = {}};
  const Study& study = plan.study;
  plan.scenes.reserve(study.combinations());
  for (std::size_t c = 0; c < study.combinations(); ++c) {
    const std::vector<std::size_t> choice = study.choice(c);
    end_if_interrupted("any cell was run");
    plan.scenes.push_back(
        load_combination(study, choice, plan.scenes.empty() ? nullptr : &plan.scenes.back()));
    const Scene& scene = plan.scenes.back();
    if (c == 0) plan.warnings = scene.warnings;
    const SessionInput input = session_input(scene);
    for (const std::uint64_t seed : study.seeds) {
      StudyCell cell{.choice = choice, .seed = seed, .scene = c, .options = scene.session, .key = {}};
      cell.options.clock.kind = Clock::virtual_time;
      cell.options.workers.threads = 1;
      cell.options.seed = seed;
      if (const auto speed = number_of(study, choice, "speed"))
        cell.options.motion.device =
            device_at_speed(cell.options.motion.device, *speed, axis_place(study, "speed"));
      if (study.sustained) device_at_speed(cell.options.motion.device, 1, study.sustained_place);
      check_arrivals(study, scene, cell.options, plan.warnings);
      check_cell(study, scene, input, cell.options);
      if (const auto load = number_of(study, choice, "target_load")) {
        const double demand = states_needed_per_second(scene, cell.options);
        if (demand <= 0)
          throw InputError(axis_place(study, "target_load"),
                           fmt::format("device '{}' needs no state of the box, expected a "
                                       "motion through it",
                                       cell.options.motion.device));
        cell.options.workers.cost =
            cost_for_load(*load, cell.options, demand, axis_place(study, "target_load"));
        if (cell.options.motion.device.starts_with("hand:")) {
          cell.load_to_find = *load;
          cell.free_demand = demand;
        }
      }
      cell.key = key_of(scene, cell.options, study);
      plan.cells.push_back(std::move(cell));
    }
  }
  return plan;
}

}  // namespace forefeel
