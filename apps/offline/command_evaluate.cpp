// forefeel evaluate STATES --points Q.csv: approximated forces (approx/methods/evaluate.hpp). Each point
// gets its own neighbour set; an older method (--method) uses all states.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <span>

#include "approx/methods/evaluate.hpp"
#include "approx/model/lattice_field.hpp"
#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/spacing_check.hpp"
#include "apps/console/units.hpp"
#include "apps/console/values.hpp"
#include "apps/offline/evaluate_json.hpp"
#include "apps/offline/evaluate_sites.hpp"
#include "apps/offline/forces_csv.hpp"
#include "apps/offline/offline_bars.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/check_solves.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_summary.hpp"

namespace forefeel {
namespace {

struct ModelArguments {
  std::optional<std::string> method, kernel, data, select, ridge;
  std::optional<std::size_t> neighbours;
};

struct EvaluateArguments {
  std::string states, points, output, scene;
  ModelArguments model;
  std::optional<double> spacing;
  KnownNoise noise;
  std::optional<double> stiffest;  // across measured states [N/m]
  bool foreign = false, no_bars = false;
};

double ridge_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, value);
  if (failed != std::errc() || stopped != end || !(value >= 0) || !std::isfinite(value))
    throw InputError("--ridge", fmt::format("is '{}', expected a number >= 0 or auto", text));
  return value;
}

// The value with this name; the parser has already refused unknown names.
template <class Value>
std::optional<Value> value_named(const std::optional<std::string>& text, std::span<const Value> values) {
  for (const Value value : values)
    if (text && name(value) == *text) return value;
  return {};
}

EvaluateOptions options_of(const ModelArguments& arguments) {
  constexpr std::array kernels{Kernel::linear, Kernel::cubic, Kernel::quintic};
  constexpr std::array data{Data::force, Data::force_and_stiffness, Data::jet};
  constexpr std::array rules{Select::label, Select::nearest};
  EvaluateOptions options;
  if (arguments.method) options.choose = *arguments.method == "auto";
  options.method = value_named(arguments.method, all_methods());
  options.model.kernel = value_named<Kernel>(arguments.kernel, kernels);
  options.model.data = value_named<Data>(arguments.data, data);
  options.model.select = value_named<Select>(arguments.select, rules);
  options.model.neighbours = arguments.neighbours;
  options.choose_ridge = arguments.ridge == "auto" && options.choose != true;
  if (arguments.ridge && *arguments.ridge != "auto") options.model.ridge = ridge_of(*arguments.ridge);
  return options;
}

// The older methods ignore some options; a warning says which.
void warn_of_unused(const Globals& globals, const ModelArguments& arguments) {
  const std::string method = arguments.method.value_or("rbf");
  if (arguments.data == "jet") {
    std::vector<std::string> beside_jets;
    if (arguments.select) beside_jets.push_back("--select");
    if (arguments.kernel) beside_jets.push_back("--kernel");
    if (arguments.ridge) beside_jets.push_back("--ridge");
    if (!beside_jets.empty())
      warn(globals, fmt::format("{}: without effect where a force comes from energy jets",
                                fmt::join(beside_jets, ", ")));
  }
  if (method == "rbf" || method == "auto") return;
  const bool offline = method == "offline-rbf";
  std::vector<std::string> unused;
  if (arguments.select) unused.push_back("--select");
  if (arguments.kernel && !offline) unused.push_back("--kernel");
  if (arguments.data && !offline) unused.push_back("--data");
  if (arguments.neighbours && method != "rbf-network") unused.push_back("--neighbours");
  if (arguments.ridge && !offline) unused.push_back("--ridge");
  if (!unused.empty())
    warn(globals, fmt::format("{}: without effect on --method {}", fmt::join(unused, ", "), method));
}

// Noise and the stiffness across are those of the process of measured forces, if it is used.
void warn_of_unused_noise(const Globals& globals, const EvaluateArguments& arguments,
                          std::span<const State> known, const Evaluation& found) {
  if (found.field && found.chosen) return;
  const bool measured = found.field || (!found.chosen && std::ranges::none_of(known, &State::has_stiffness));
  std::vector<std::string> unused;
  if (arguments.noise.force) unused.push_back("--noise");
  if (arguments.noise.position) unused.push_back("--position-noise");
  if (arguments.stiffest && !found.field) unused.push_back("--stiffest");
  if (!unused.empty())
    warn(globals, fmt::format("{}: without effect on {}", fmt::join(unused, ", "),
                              found.method != Method::rbf ? fmt::format("--method {}", name(found.method))
                              : measured                  ? "a model that is given; expected --method auto"
                                         : "states with stiffness or with fewer than 8 positions"));
}

std::vector<Vec3> read_points(const std::string& file) {
  std::vector<Vec3> points = read_points_csv(file);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw InputError(fmt::format("{}: point {}", file, i + 1), "is not finite, expected three numbers");
  if (points.empty()) throw InputError(file, "holds no point, expected rows x,y,z");
  return points;
}

// The states, and whether they were taken as those of another body; nothing without a scene.
struct EvaluatedStates {
  std::vector<State> states = {};
  double spacing = unknown;  // [m]
  std::string value = {};    // name of what they tell instead of a force
  CheckSolves checks = {};
  std::optional<Belonging> belonging = {};
  std::optional<MeshError> mesh = {};  // of the scene's body, unless the states are of another
};

EvaluatedStates read_known(const Globals& globals, const EvaluateArguments& arguments) {
  LoadedStates loaded = load_states(arguments.states, Tells::value);
  if (loaded.damaged > 0) warn(globals, damage_in_words(arguments.states, loaded.damaged));
  if (std::ranges::any_of(loaded.states, &State::has_site))
    throw InputError(arguments.points, fmt::format("has no columns sx,sy,sz, expected them: the states of {} "
                                                   "touch at sites of the surface",
                                                   arguments.states));
  if (std::ranges::none_of(loaded.states, &State::usable))
    throw InputError(arguments.states, "holds no solved state, expected at least one");
  EvaluatedStates known{
      .spacing = loaded.header.spacing, .value = loaded.value, .checks = check_solves(loaded.header)};
  if (loaded.tells == Tells::value && known.value.empty()) known.value = "value";
  if (!arguments.scene.empty()) {
    const Scene scene = load_scene(arguments.scene, globals.set);
    for (const std::string& warning : scene.source.warnings) warn(globals, warning);
    known.belonging = belonging_of(globals, scene, arguments.states, loaded.header.identity,
                                   averaged(loaded.states).states, arguments.foreign);
    if (!(known.spacing > 0)) known.spacing = scene.space.spacing;
    if (known.belonging != Belonging::foreign)
      known.mesh = MeshErrorTask(scene, MeshErrorTask::When::at_the_end).get();
  }
  if (arguments.spacing) known.spacing = *arguments.spacing;
  known.states = std::move(loaded.states);
  if (!arguments.model.data && !arguments.model.method && !arguments.model.kernel &&
      std::ranges::any_of(known.states, [](const State& s) { return s.jet != nullptr; }))
    warn(globals, fmt::format("{}: holds energy jets, which are used with --data jet", arguments.states));
  if (arguments.spacing)
    if (const auto line =
            spacing_beyond("--spacing", known.spacing, summarise(known.states).extent, "the states"))
      warn(globals, *line);
  if (loaded.header.identity.empty() && loaded.tells == Tells::force)
    for (const std::string& line : misleading(known.states, known.spacing))
      warn(globals, fmt::format("{}: {}", arguments.states, line));
  return known;
}

// A lattice method interpolates in full cells alone.
void warn_of_cells(const Globals& globals, const EvaluateArguments& arguments, std::span<const State> known,
                   const EvaluateResult& result) {
  const Method method = result.found.method;
  if (method != Method::trilinear && method != Method::tricubic) return;
  LatticeCells cells(result.found.options.spacing);
  for (const State& state : known)
    if (state.usable()) cells.add(state.at);
  const auto without = static_cast<std::size_t>(
      std::ranges::count_if(result.points, [&](const Vec3& x) { return !cells.around(x); }));
  if (without > 0)
    warn(globals,
         fmt::format("{}, --method {}: no full lattice cell holds {} of {}: {}", arguments.states,
                     name(method), without, counted(result.points.size(), "point"), instead_of_cells));
}

EvaluateResult evaluate_command(const Globals& globals, const EvaluateArguments& arguments) {
  EvaluateOptions options = options_of(arguments.model);
  Progress progress(globals, "evaluate");
  progress.show("reading " + arguments.states);
  EvaluateResult result{.points = read_points(arguments.points), .found = {}, .belonging = {}, .mesh = {}};
  EvaluatedStates known = read_known(globals, arguments);
  if (!arguments.output.empty()) check_writable(arguments.output, {arguments.states, arguments.points});
  options.spacing = known.spacing;
  options.checks = known.checks;
  options.bars = !arguments.no_bars;
  options.noise = arguments.noise;
  options.stiffest = arguments.stiffest;
  result.belonging = known.belonging;
  result.mesh = known.mesh;
  result.value = known.value;
  options.show = stages_of(progress, "evaluate");
  try {
    result.found = evaluate(known.states, result.points, options);
  } catch (const InputError& error) {
    if (error.place().key == "states") throw InputError(arguments.states, error.problem());
    throw;
  }
  warn_of_unused_noise(globals, arguments, known.states, result.found);
  warn_of_cells(globals, arguments, known.states, result);
  if (const std::string line = contradictions_in_words(arguments.states, result.found.repeated, known.states);
      !line.empty())
    warn(globals, line);
  return result;
}

std::string kernel_in_words(const Evaluation& result) {
  if (result.chosen && result.chosen->field)
    return fmt::format("Gaussian process {}{}", name(result.chosen->field->law.smoothness),
                       result.chosen->field->local ? " of each place" : "");
  return std::string(name(result.options.model.kernel));
}

// ", quintic on force+stiffness, 25 neighbours"
std::string result_in_words(const Evaluation& result, const Told& told) {
  const ModelOptions& model = result.options.model;
  const EvaluatedPoints& made = result.made;
  std::string how;
  if (result.method == Method::rbf || result.method == Method::offline_rbf)
    how = fmt::format(", {} on {}", kernel_in_words(result),
                      told.unit.empty() ? told.things : name(model.data));
  const bool all = result.chosen && result.chosen->all;
  if (result.method == Method::rbf && !all) how += ", " + counted(model.neighbours, "neighbour");
  if (all) how += ", one model of all states";
  if (result.chosen && !all) how += fmt::format(" by rule {}", name(model.select));
  if (result.chosen && !result.chosen->field) how += fmt::format(", ridge {:g}", model.ridge);
  if (result.field) how += fmt::format(", noise {:.2g}{}", result.field->law.noise, told.unit);
  if (result.method == Method::rbf_network) how = ", " + counted(result.options.centres, "centre");
  if (made.stepped_down > 0)
    how += fmt::format(
        ", at {} stepped down, the first to {}", counted(made.stepped_down, "point"),
        *std::ranges::find_if(made.kernels, [&](std::string_view k) { return k != name(model.kernel); }));
  return how;
}

void tell(const Globals& globals, const EvaluateResult& evaluated, bool with_forces) {
  const Evaluation& result = evaluated.found;
  const EvaluatedPoints& made = result.made;
  const Told told = evaluated.value.empty() ? Told{} : Told{.unit = "", .things = "values"};
  if (with_forces)
    for (std::size_t i = 0; i < evaluated.points.size(); ++i) {
      const Vec3 &x = evaluated.points[i], &f = made.forces[i];
      const bool barred = result.bars && std::isfinite(result.bars->at[i][1]);
      const std::string what = evaluated.value.empty()
                                   ? fmt::format("f = ({:.6g}, {:.6g}, {:.6g}) N", f[0], f[1], f[2])
                                   : fmt::format("{} = {:.6g}", evaluated.value, f[0]);
      answer(globals,
             fmt::format("x = ({:.6g}, {:.6g}, {:.6g}) m  {}{}  {}{}", x[0], x[1], x[2], what,
                         barred ? fmt::format(" +- {:.3g}{} (95 %)", result.bars->at[i][1], told.unit) : "",
                         name(made.labels[i]),
                         made.trusted.empty() ? ""
                         : made.trusted[i]    ? ", trusted"
                                              : ", not trusted"));
    }
  std::string models = fmt::format("{} fitted", made.fitted);
  if (made.updated > 0) models += fmt::format(", {} updated", made.updated);
  if (made.reused > 0) models += fmt::format(", {} reused", made.reused);
  std::string heap;
  if (result.heaped > 0)
    heap = fmt::format(" ({} about one place count as one)", counted(result.heaped, "row"));
  if (result.far_row_left_out) heap += " (the one row far from all others has no part)";
  say(globals, fmt::format("{} from {}{}: {}{}; models: {}; medians: fit {}, evaluation {}",
                           counted(evaluated.points.size(), "point"), counted(result.states, "state"), heap,
                           result.chosen ? "auto" : name(result.method), result_in_words(result, told),
                           models, short_time(1e-6 * result.fit_us), short_time(1e-9 * result.evaluate_ns)));
  const double shown = evaluated.shown();
  const bool mesh_first = evaluated.mesh && evaluated.mesh->error > shown;
  if (mesh_first) answer(globals, discretisation_line(*evaluated.mesh, shown));
  if (result.chosen) answer(globals, expectation_in_words(*result.chosen, result.shared, told));
  if (result.bars) answer(globals, bars_in_words(*result.bars, true, told));
  if (evaluated.mesh && !mesh_first) answer(globals, discretisation_line(*evaluated.mesh, shown));
}

int run_evaluate(const Globals& globals, const EvaluateArguments& arguments, const Command& command) {
  if (has_site_columns(arguments.points)) {
    for (const char* option :
         {"--method", "--kernel", "--data", "--select", "--ridge", "--neighbours", "--spacing", "--noise",
          "--position-noise", "--stiffest", "--no-bars", "--foreign"})
      if (command.given(option))
        throw InputError(option,
                         "is not for points with sites, where the field at rest answers; expected none");
    return evaluate_sites(globals, {arguments.states, arguments.points, arguments.scene, arguments.output});
  }
  warn_of_unused(globals, arguments.model);
  if (!globals.set.empty() && arguments.scene.empty())
    warn(globals, "--set: without effect on evaluate without --scene");
  if (arguments.foreign && arguments.scene.empty())
    throw InputError("--foreign", "is about states beside a scene, expected it with --scene");
  const EvaluateResult result = evaluate_command(globals, arguments);
  if (!arguments.output.empty()) write_forces(arguments.output, result.points, result.found, result.value);
  if (globals.json)
    print_json(to_json(result));
  else
    tell(globals, result, arguments.output.empty());
  if (!arguments.output.empty())
    say(globals,
        fmt::format("{} at the points: {}", result.value.empty() ? "forces" : "values", arguments.output));
  return 0;
}

}  // namespace

void add_evaluate(CommandLine& line) {
  const auto arguments = std::make_shared<EvaluateArguments>();
  Command sub = line.add("evaluate", "Forces approximated from known states at given points");
  sub.runs([arguments, sub](const Globals& globals) { return run_evaluate(globals, *arguments, sub); });
  sub.option("STATES", arguments->states, "State file, or states as CSV").required();
  sub.option("--points", arguments->points,
             "CSV of positions x,y,z [m]; with contact.anywhere sx,sy,sz,x,y,z")
      .required()
      .shows("Q.csv");
  sub.option(
         "--method", arguments->model.method,
         "Approximation. auto chooses kernel, neighbours and ridge by leaving out groups of neighbouring "
         "states, and prints the expected error; options that are given stay fixed. Default: auto for states "
         "without stiffness if none of kernel, data, neighbours and ridge is given, else rbf")
      .one_of(
          {"auto", "rbf", "trilinear", "tricubic", "deflection", "two-force", "offline-rbf", "rbf-network"});
  sub.option("--kernel", arguments->model.kernel,
             "Radial function. Default of rbf: quintic for states with stiffness, else cubic")
      .one_of({"linear", "cubic", "quintic"});
  sub.option("--data", arguments->model.data,
             "What a model fits. Default: force+stiffness if the states have it")
      .one_of({"force", "force+stiffness", "jet"});
  sub.option("--neighbours", arguments->model.neighbours,
             "Number of states in a model. Default: 25, 100 for states without stiffness, 8 with --data jet. "
             "With --select "
             "label a "
             "model has more where they are needed: at least 16 outside safe regions (without stiffness at "
             "least 20 "
             "everywhere), and up to 32 more in a gap; 1 stays 1. For rbf-network: number of centres")
      .check(above_zero)
      .check([](const std::string& text) {
        const double n = std::strtod(text.c_str(), nullptr);
        return n >= 1 && n <= 100'000 ? "" : "is " + text + ", expected a whole number from 1 to 100000";
      });
  sub.option("--select", arguments->model.select,
             "Which states a model uses: nearest, or label (outside safe regions from all sides of the "
             "point). Default "
             "of rbf: label")
      .one_of({"label", "nearest"});
  sub.option("--spacing", arguments->spacing,
             "Distance of states that counts as dense [m]. Default: that of the file, else estimated from "
             "the states")
      .check(above_zero);
  sub.option("--ridge", arguments->model.ridge,
             "For noisy states: added to the kernel's diagonal; auto: chosen by leaving out single states. "
             "Default of rbf: 0")
      .shows("NUMBER|auto");
  sub.option("--noise", arguments->noise.force,
             "Deviation of one component of a measured force [N]. Default: estimated from the states")
      .shows("NEWTON")
      .check(zero_or_more);
  sub.option(
         "--position-noise", arguments->noise.position,
         "Deviation of one coordinate of a measured position [m]. Default: its effect is part of the noise")
      .shows("METRE")
      .check(zero_or_more);
  sub.option("--stiffest", arguments->stiffest,
             "Stiffness that the body seldom (5 %) exceeds across a line or a surface of measured states "
             "[N/m], for the error where they tell nothing. Default: three times the largest along them")
      .shows("NEWTON/METRE")
      .check(above_zero);
  sub.option("--scene", arguments->scene,
             "Scene of the states' body. States that name no body are compared with it and refused if they "
             "differ")
      .shows("SCENE");
  sub.flag("--foreign", arguments->foreign, foreign_help);
  sub.flag(
      "--no-bars", arguments->no_bars,
      "No error bars, whose forces left out in groups take seconds with thousands of states. auto still fits "
      "the "
      "field of measured forces, one of the models that it compares, unless kernel, neighbours, select or "
      "ridge is "
      "given");
  sub.option("-o,--output", arguments->output, "Forces as CSV").shows("OUT.csv");
}

}  // namespace forefeel
