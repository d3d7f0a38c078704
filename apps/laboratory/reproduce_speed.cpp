// Sustained HIP speed against the number of workers. Sustained is the highest speed at which 95 % of first
// visits are within 7 % of the reference; a first visit is the first frame in a cell of 6 mm. Each run starts
// with no states and follows lines across the whole box and slightly beyond it, layer by layer. Each step of
// speed_steps.hpp is one row. The cells are those of a study, so an interrupted run resumes.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "apps/laboratory/reproduce.hpp"
#include "apps/laboratory/speed_report.hpp"
#include "apps/laboratory/speed_steps.hpp"
#include "apps/picture/figure.hpp"
#include "apps/scene/scene_session.hpp"
#include "apps/study/planned_study.hpp"
#include "apps/study/study_folder.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/study/speed_bound.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// The study leaves out the keys that --set gives.
bool is_set(const Globals& globals, const std::string& key) {
  return std::ranges::any_of(globals.set,
                             [&](const std::string& text) { return text.starts_with(key + "="); });
}

// ---- the study

Study speed_study(const ReproduceOptions& runs) {
  Study study{.seeds = {},
              .axes = {{"step", {}}, {"workers", {}}},
              .sustained = SustainedOptions{
                  .travel = runs.travel, .share = 0.95, .tolerance = 0.07, .low = 0.015625, .high = 2.0}};
  for (int seed = 1; seed <= runs.seeds; ++seed) study.seeds.push_back(static_cast<std::uint64_t>(seed));
  for (const SpeedStep& step : speed_steps()) study.axes[0].values.push_back({step.name});
  for (const int workers : runs.workers) study.axes[1].values.push_back({std::to_string(workers)});
  return study;
}

// The settings common to all steps.
SpeedSettings shared_settings(const Laboratory& laboratory) {
  SpeedSettings shared{.options = laboratory.scene().session, .spacing = laboratory.spacing()};
  const Globals& globals = laboratory.globals();
  shared.options.motion.device = is_set(globals, "session.device") ? device_of(laboratory.scene())
                                                                   : PathMotion{.path = PathName::raster};
  shared.options.workers.cost = is_set(globals, "session.cost") ? cost_of(laboratory.scene()) : PaperCost{};
  if (!is_set(globals, "session.reference_step"))
    shared.options.judging.reference_step = 0.5;  // only first visits are judged
  shared.options.judging.visit_cell = 0.006;
  return shared;
}

// Checks what a session would refuse; the error names the option of the command.
InputError at_its_place(const InputError& error, const Globals& globals) {
  const std::string& key = error.place().key;
  if (!error.place().file.empty()) return error;
  if (key.starts_with("study.")) return {"reproduce speed: " + key.substr(6), error.problem()};
  if (is_set(globals, key)) return {{.option = "--set", .key = key}, error.problem()};
  return error;
}

StudyPlan plan_speed(const Laboratory& laboratory, const ReproduceOptions& runs) {
  const Scene& scene = laboratory.scene();
  const Study study = speed_study(runs);
  const std::vector<SpeedSettings> steps = speed_settings(shared_settings(laboratory));
  const auto session_of = [&](std::span<const std::size_t> choice) {
    const SpeedSettings& step = steps[choice[0]];
    StudySession session{.input = session_input(scene), .options = step.options};
    session.input.touched.space = space_at(scene, step.spacing);
    session.options.model.fit.length = step.spacing;
    session.options.workers.count = runs.workers[choice[1]];
    return session;
  };
  try {
    StudyPlan plan = plan_study(study, session_of);
    for (StudyCell& cell : plan.cells) {
      const std::string content = fmt::format("{}\nreproduce speed: {}\n{} workers", scene.source.hash,
                                              speed_steps()[cell.choice[0]].name, cell.options.workers.count);
      cell.key = cell_key(content, cell, plan.inputs[cell.input], study.sustained);
    }
    return plan;
  } catch (const InputError& error) {
    throw at_its_place(error, laboratory.globals());
  }
}

// ---- the same study as files, so that it can be rerun on its own: forefeel study DIR/speed.toml

constexpr const char* built_in_file = "scene.toml";  // the built-in scene, beside the study's file
constexpr const char* study_file = "speed.toml";

std::string in_quotes(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '\\' || c == '"' ? std::string{'\\', c} : std::string(1, c);
  return quoted + "\"";
}

// The first step gives all settings, each later one its changes.
std::string steps_text(const SpeedSettings& shared) {
  std::string text;
  std::vector<std::pair<std::string, std::string>> before;
  const std::vector<SpeedSettings> steps = speed_settings(shared);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    text += fmt::format("\n[[step]]\nname = {}\n", in_quotes(speed_steps()[s].name));
    const auto keys = scene_keys(steps[s]);
    for (std::size_t k = 0; k < keys.size(); ++k)
      if (before.empty() || keys[k].second != before[k].second)
        text += fmt::format("\"{}\" = {}\n", keys[k].first, keys[k].second);
    before = keys;
  }
  return text;
}

std::string study_text(const Laboratory& laboratory, const ReproduceOptions& runs) {
  const std::string scene =
      laboratory.built_in() ? built_in_file : fs::absolute(laboratory.scene().source.file).string();
  const Study study = speed_study(runs);
  const SpeedSettings shared = shared_settings(laboratory);
  std::string text =
      fmt::format("scene = {}\nseeds = [{}]\n\n[session]\n", in_quotes(scene), fmt::join(study.seeds, ", "));
  if (!is_set(laboratory.globals(), "session.device"))
    text += fmt::format("device = {}\n", in_quotes(to_text(shared.options.motion.device)));
  if (!is_set(laboratory.globals(), "session.cost"))
    text += fmt::format("cost = {}\n", in_quotes(to_text(shared.options.workers.cost)));
  if (!is_set(laboratory.globals(), "session.reference_step"))
    text += fmt::format("reference_step = {}    # m; first visits are sampled anyway\n",
                        shared.options.judging.reference_step);
  const SustainedOptions& sought = *study.sustained;
  text += fmt::format("visit_cell = {}       # m\n\n[sustained]\ntravel = {}\nshare = {}\n",
                      shared.options.judging.visit_cell, sought.travel, sought.share);
  text += fmt::format("tolerance = {}\nlow = {}\nhigh = {:.1f}\n", sought.tolerance, sought.low, sought.high);
  return text + steps_text(shared) + fmt::format("\n[vary]\nworkers = [{}]\n", fmt::join(runs.workers, ", "));
}

void write_study(const Laboratory& laboratory, const ReproduceOptions& runs, const fs::path& folder) {
  if (laboratory.built_in()) write_whole(folder / built_in_file, std::string(built_in_scene_text()));
  write_whole(folder / study_file, study_text(laboratory, runs));
}

// ---- results

std::vector<std::vector<double>> speeds_of(const StudyPlan& plan, const StudyResult& result) {
  const std::vector<StudyAxis>& axes = plan.study.axes;
  std::vector<std::vector<double>> sums(axes[0].values.size(),
                                        std::vector<double>(axes[1].values.size(), 0.0));
  for (std::size_t i = 0; i < plan.cells.size(); ++i) {
    const double speed = result.cells[i].number("sustained.speed");
    sums[plan.cells[i].choice[0]][plan.cells[i].choice[1]] += speed > 0 ? std::log(speed) : -INFINITY;
  }
  for (auto& row : sums)
    for (double& v : row) v = std::exp(v / static_cast<double>(plan.study.seeds.size()));
  return sums;
}

SpeedBounds bounds_of(const StudyPlan& plan, const Globals& globals) {
  SpeedBounds all;
  double cells = 0;
  for (const StudyCell& cell : plan.cells) {
    // The bounds do not depend on the number of workers.
    if (speed_steps()[cell.choice[0]].role != SpeedRole::ours || cell.choice[1] != 0) continue;
    const SessionInput& input = plan.inputs[cell.input];
    ReferenceService references(reference_options(input), globals.threads);
    const SustainedOptions& sought = *plan.study.sustained;
    const SpeedBound guessed = speed_bound(sought, cell, input, references, true),
                     without = speed_bound(sought, cell, input, references, false);
    all.guessed *= guessed.speed;
    all.without *= without.speed;
    all.known += guessed.known;
    all.settled += guessed.settled_after;
    all.settled_without += without.settled_after;
    ++cells;
  }
  for (double* speed : {&all.guessed, &all.without}) *speed = std::pow(*speed, 1 / cells);
  for (double* time : {&all.known, &all.settled, &all.settled_without}) *time /= cells;
  return all;
}

}  // namespace

void check_speed_overrides(const Globals& globals) {
  for (const std::string& text : globals.set) {
    const std::string key = text.substr(0, text.find('='));
    const InputPlace place{.option = "--set", .key = key};
    for (const char* own : {"workers", "seconds", "clock", "seed"})
      if (key == own || key == std::string("session.") + own)
        throw InputError(place, "is what `speed` sets itself, expected another key");
    if (const std::string step = step_that_changes(key); !step.empty())
      throw InputError(
          place, fmt::format("is what `speed` compares (step '{}' changes it), expected another key", step));
  }
}

void check_speed(const Laboratory& laboratory, const ReproduceOptions& runs) {
  plan_speed(laboratory, runs);
}

Findings reproduce_speed(Laboratory& laboratory, const ReproduceOptions& runs, const fs::path& folder,
                         const ShowShare&) {
  const StudyPlan plan = plan_speed(laboratory, runs);
  write_study(laboratory, runs, folder);
  const StudyResult result = run_study_in({folder / "speed"}, {}, plan, laboratory.globals());
  if (result.interrupted)
    return {.summary = {{"interrupted", true}},
            .html = {},
            .lines = {},
            .unmet = {"interrupted; the same command resumes"}};
  const SpeedFindings found{.workers = runs.workers,
                            .speeds = speeds_of(plan, result),
                            .bounds = bounds_of(plan, laboratory.globals()),
                            .travel = runs.travel,
                            .seeds = runs.seeds};
  write_speed_csv(folder / "speed.csv", found);
  return speed_report(found, folder);
}

}  // namespace forefeel
