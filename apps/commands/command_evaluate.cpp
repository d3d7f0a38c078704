// forefeel evaluate STATES --points Q.csv: approximated forces. Each point gets its own neighbour set; an
// older method (--method) uses all states.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "approx/judge/leave_one_out.hpp"
#include "approx/model/model_options.hpp"
#include "approx/predecessors/methods.hpp"
#include "approx/select/updater.hpp"
#include "geometry/states/repeated_states.hpp"
#include "apps/commands/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/values.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/estimate_spacing.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

struct EvaluateArguments {
  std::string states, points, output, method = "rbf", kernel, data, select = "label";
  std::optional<std::size_t> neighbours;
  std::optional<double> spacing;
  std::string ridge = "0";
};

// Limits of a model. Its force never exceeds `bound` [N]. Outside the hull of its states the model is
// replaced by its tangent beyond `tangent` [m]; the force is held constant beyond `held` [m] from where the
// tangent is taken.
struct Reach {
  double bound, tangent, held;
};

struct Evaluation {
  std::vector<Reach> reach;  // by point; no tangent for the older methods
  std::vector<Vec3> forces;
  std::vector<Label> labels;
  std::vector<double> fit_us, evaluate_ns;  // fit_us: of those points whose model was made or changed
  std::size_t fitted = 0, updated = 0,
              reused = 0;                 // number of points whose model was made anew, updated, kept
  std::vector<std::string_view> kernels;  // by point, after step-down; none for the older methods
  std::size_t stepped_down = 0;
};

std::vector<State> usable_states(std::vector<State> states) {
  std::erase_if(states, [](const State& s) { return !s.usable(); });
  return states;
}

ModelOptions model_options(const EvaluateArguments& arguments, const std::vector<State>& states) {
  const bool stiffness =
      std::ranges::any_of(states, [](const State& s) { return s.usable() && s.has_stiffness(); });
  ModelOptions options;
  const bool offline =
      arguments.method == "offline-rbf";  // one model of all states; uses forces alone unless --data is given
  options.kernel = arguments.kernel == "linear"  ? Kernel::linear
                   : arguments.kernel == "cubic" ? Kernel::cubic
                   : !arguments.kernel.empty()   ? Kernel::quintic
                   : stiffness && !offline       ? Kernel::quintic
                                                 : Kernel::cubic;
  if (arguments.data.empty())
    options.data =
        stiffness && !offline && options.kernel != Kernel::linear ? Data::force_and_stiffness : Data::force;
  else
    options.data = arguments.data == "force" ? Data::force : Data::force_and_stiffness;
  if (options.data == Data::force_and_stiffness && !stiffness)
    throw InputError(arguments.states,
                     "no state has a stiffness, expected columns k11 to k33 or --data force");
  options.neighbours = arguments.neighbours.value_or(options.data == Data::force ? 100 : 25);
  options.neighbours = std::min(options.neighbours, std::max<std::size_t>(states.size(), 1));
  options.select = arguments.select == "nearest" ? Select::nearest : Select::label;
  return options;
}

double ridge_of(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, value);
  if (failed != std::errc() || stopped != end || !(value >= 0) || !std::isfinite(value))
    throw InputError("--ridge", fmt::format("is '{}', expected a number >= 0 or auto", text));
  return value;
}

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// One point. Its evaluation is repeated so that the clock resolves its time.
template <class Field>
void measure(const Field& field, const Vec3& x, Evaluation& result) {
  result.forces.push_back(field.force(x));
  constexpr int repeats = 16;
  Vec3 sum = Vec3::Zero();
  const auto begin = Clock::now();
  for (int r = 0; r < repeats; ++r) sum += field.force(x);
  result.evaluate_ns.push_back(sum.allFinite() ? 1e9 * since(begin) / repeats : unknown);
}

// The kernel used. It is a simpler one if the states do not determine the polynomial (rbf_fit.hpp).
std::string_view kernel_of(const Model& model) {
  if (model.is_tangent()) return "tangent";
  return model.degree() == 0 ? "linear with constant" : name(model.kernel());
}

Evaluation evaluate(const StateSpace& space, const std::vector<Vec3>& points, const ModelOptions& options,
                    const Globals& globals) {
  ModelUpdater updater(space, options);
  Model model;
  model.reserve(options);
  Evaluation result;
  Progress progress(globals, "evaluate");
  for (std::size_t i = 0; i < points.size(); ++i) {
    UpdateReport report;
    updater.forget();
    const auto start = Clock::now();
    updater.update(points[i], model, &report);
    const double seconds = since(start);
    const bool changed = report.refit || report.replaced > 0;
    if (changed) result.fit_us.push_back(1e6 * seconds);
    ++(report.refit ? result.fitted : changed ? result.updated : result.reused);
    result.labels.push_back(report.label);
    result.kernels.push_back(kernel_of(model));
    result.stepped_down += result.kernels.back() != name(options.kernel) ? 1 : 0;
    result.reach.push_back({model.force_bound(), 2 * model.trust_distance(), model.hold_distance()});
    measure(model, points[i], result);
    progress.show(double(i + 1) / double(points.size()),
                  fmt::format("{} of {} points", i + 1, points.size()));
  }
  return result;
}

Evaluation evaluate_older(Method method, const std::vector<State>& states, const StateSpace& space,
                          const std::vector<Vec3>& points, const MethodOptions& options) {
  Evaluation result;
  const auto start = Clock::now();
  const Approximation field(method, states, options);
  result.fit_us.push_back(1e6 * since(start));
  result.fitted = 1;  // one field for all points
  result.reused = points.size() - 1;
  for (const Vec3& x : points) {
    result.labels.push_back(space.coverage(x).label);
    result.reach.push_back({field.bound(x), unknown, unknown});
    measure(field, x, result);
  }
  return result;
}

Method method_of(const std::string& text) {
  for (const Method method : all_methods())
    if (name(method) == text) return method;
  return Method::rbf;
}

void write_csv(const std::string& file, const std::vector<Vec3>& points, const Evaluation& result) {
  OutputFile out(file);
  out.write("x,y,z,fx,fy,fz,label\n");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 &x = points[i], &f = result.forces[i];
    out.write(
        fmt::format("{},{},{},{},{},{},{}\n", x[0], x[1], x[2], f[0], f[1], f[2], name(result.labels[i])));
  }
  out.commit();
}

// The older methods ignore some options; a warning says which.
void warn_of_unused(const Globals& globals, const EvaluateArguments& arguments) {
  if (arguments.method == "rbf") return;
  const bool offline = arguments.method == "offline-rbf";
  std::vector<std::string> unused;
  if (arguments.select != "label") unused.push_back("--select");
  if (!arguments.kernel.empty() && !offline) unused.push_back("--kernel");
  if (!arguments.data.empty() && !offline) unused.push_back("--data");
  if (arguments.neighbours && arguments.method != "rbf-network") unused.push_back("--neighbours");
  if (arguments.ridge != "0" && !offline) unused.push_back("--ridge");
  if (!unused.empty())
    warn(globals,
         fmt::format("{}: without effect on --method {}", fmt::join(unused, ", "), arguments.method));
}

// Refuses a model that does not fit into memory, as a session does.
void check_memory(const ModelOptions& options, std::size_t states) {
  try {
    for_states(options, states);
  } catch (const InputError& error) {
    throw InputError("--neighbours", error.problem());
  }
}

std::vector<Vec3> read_points(const std::string& file) {
  std::vector<Vec3> points = read_points_csv(file);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw InputError(fmt::format("{}: point {}", file, i + 1), "is not finite, expected three numbers");
  if (points.empty()) throw InputError(file, "holds no point, expected rows x,y,z");
  return points;
}

std::vector<State> read_known(const Globals& globals, const EvaluateArguments& arguments, double& spacing) {
  LoadedStates loaded = load_states(arguments.states);
  if (loaded.damaged > 0) warn(globals, damage_in_words(arguments.states, loaded.damaged));
  if (std::ranges::none_of(loaded.states, &State::usable))
    throw InputError(arguments.states, "holds no solved state, expected at least one");
  spacing = arguments.spacing.value_or(loaded.header.spacing);
  return std::move(loaded.states);
}

// Keeps the first of states at the same position.
StateSpace space_of(const Globals& globals, const EvaluateArguments& arguments,
                    const std::vector<State>& states, double spacing) {
  if (!(spacing > 0)) spacing = estimate_spacing(usable_states(states));
  StateSpace space({.spacing = spacing > 0 ? spacing : StateSpaceOptions{}.spacing});
  std::size_t contradicting = 0;
  for (const State& state : states) {
    if (!state.usable()) continue;
    const StateSpace::Insertion made = space.insert(state);
    contradicting += !made.is_new && contradict(space[made.id], state) ? 1 : 0;
  }
  if (contradicting > 0)
    warn(globals, fmt::format("{}: {} another at the same position{}", arguments.states,
                              contradicting == 1 ? "1 state contradicts"
                                                 : fmt::format("{} states contradict", contradicting),
                              method_of(arguments.method) == Method::rbf ? "; the first is kept" : ""));
  return space;
}

// Result of `forefeel evaluate`: forces at the points, how they were computed, and the times.
struct EvaluateResult {
  Method method = Method::rbf;
  MethodOptions options;   // .model: of rbf
  std::size_t states = 0;  // known positions
  std::vector<Vec3> points;
  Evaluation made;
  double fit_us = unknown, evaluate_ns = unknown;  // medians
};

EvaluateResult evaluate(const Globals& globals, const EvaluateArguments& arguments) {
  EvaluateResult result{.method = method_of(arguments.method), .options = {}, .points = {}, .made = {}};
  result.points = read_points(arguments.points);
  double spacing = unknown;
  const std::vector<State> states = read_known(globals, arguments, spacing);
  ModelOptions& model = result.options.model = model_options(arguments, states);
  if (arguments.ridge != "auto") model.ridge = ridge_of(arguments.ridge);
  if (!arguments.output.empty()) check_writable(arguments.output, {arguments.states, arguments.points});
  const StateSpace space = space_of(globals, arguments, states, spacing);
  result.states = space.size();
  result.options.spacing = space.options().spacing;
  if (result.method == Method::rbf) check_memory(model, space.size());
  model.neighbours = std::min(model.neighbours, space.size());
  if (arguments.ridge == "auto") model.ridge = choose_ridge(space, model).ridge;
  if (result.method == Method::rbf_network)
    result.options.centres =
        RbfNetwork::centres_of(static_cast<std::size_t>(std::ranges::count_if(states, &State::usable)),
                               arguments.neighbours.value_or(0));
  result.made = result.method == Method::rbf
                    ? evaluate(space, result.points, model, globals)
                    : evaluate_older(result.method, states, space, result.points, result.options);
  result.fit_us = median(result.made.fit_us);
  result.evaluate_ns = median(result.made.evaluate_ns);
  return result;
}

// The settings of the method; null if it has no such setting.
void describe(nlohmann::ordered_json& document, const EvaluateResult& result) {
  const ModelOptions& model = result.options.model;
  const bool moving = result.method == Method::rbf, offline = result.method == Method::offline_rbf,
             network = result.method == Method::rbf_network;
  const auto if_so = [&](const char* key, bool so, nlohmann::ordered_json value) {
    document[key] = so ? std::move(value) : nlohmann::ordered_json();
  };
  if_so("kernel", moving || offline || network, name(network ? Kernel::cubic : model.kernel));
  if_so("data", true, name(moving || offline ? model.data : Data::force));
  if_so("neighbours", moving, model.neighbours);
  if_so("centres", network, result.options.centres);
  if_so("select", moving, name(model.select));
  if_so("ridge", moving || offline, model.ridge);
}

nlohmann::ordered_json to_json(const EvaluateResult& result) {
  nlohmann::ordered_json document;
  document["forces"] = nlohmann::ordered_json::array();
  document["labels"] = nlohmann::ordered_json::array();
  for (const Vec3& f : result.made.forces) document["forces"].push_back(vector3(f));
  for (const Label label : result.made.labels) document["labels"].push_back(name(label));
  document["kernels"] = result.made.kernels;
  document["stepped_down"] = result.made.stepped_down;
  document["fit_us"] = number(result.fit_us);
  document["evaluate_ns"] = number(result.evaluate_ns);
  document["fitted"] = result.made.fitted;
  document["updated"] = result.made.updated;
  document["reused"] = result.made.reused;
  document["method"] = name(result.method);
  describe(document, result);
  document["spacing"] = number(result.options.spacing);
  for (const char* key : {"force_bounds", "tangent_from", "held_from"})
    document[key] = nlohmann::ordered_json::array();
  for (const Reach& reach : result.made.reach) {
    document["force_bounds"].push_back(number(reach.bound));
    document["tangent_from"].push_back(number(reach.tangent));
    document["held_from"].push_back(number(reach.held));
  }
  return document;
}

// ", quintic on force+stiffness, 25 neighbours"
std::string in_words(const EvaluateResult& result) {
  const ModelOptions& model = result.options.model;
  const Evaluation& made = result.made;
  std::string how;
  if (result.method == Method::rbf || result.method == Method::offline_rbf)
    how = fmt::format(", {} on {}", name(model.kernel), name(model.data));
  if (result.method == Method::rbf) how += fmt::format(", {} neighbours", model.neighbours);
  if (result.method == Method::rbf_network) how = fmt::format(", {} centres", result.options.centres);
  if (made.stepped_down > 0)
    how += fmt::format(
        ", at {} points stepped down, the first to {}", made.stepped_down,
        *std::ranges::find_if(made.kernels, [&](std::string_view k) { return k != name(model.kernel); }));
  return how;
}

void tell(const Globals& globals, const EvaluateResult& result, bool with_forces) {
  const Evaluation& made = result.made;
  if (with_forces)
    for (std::size_t i = 0; i < result.points.size(); ++i) {
      const Vec3 &x = result.points[i], &f = made.forces[i];
      answer(globals, fmt::format("x = ({:.6g}, {:.6g}, {:.6g}) m  f = ({:.9g}, {:.9g}, {:.9g}) N  {}", x[0],
                                  x[1], x[2], f[0], f[1], f[2], name(made.labels[i])));
    }
  std::string models = fmt::format("{} fitted", made.fitted);
  if (made.updated > 0) models += fmt::format(", {} updated", made.updated);
  if (made.reused > 0) models += fmt::format(", {} reused", made.reused);
  say(globals,
      fmt::format("{} points from {} states: {}{}; models: {}, median fit {:.1f} us; evaluation {:.0f} ns",
                  result.points.size(), result.states, name(result.method), in_words(result), models,
                  result.fit_us, result.evaluate_ns));
}

int run_evaluate(const Globals& globals, const EvaluateArguments& arguments) {
  warn_of_unused(globals, arguments);
  if (!globals.set.empty()) warn(globals, "--set: without effect on evaluate, which reads no scene");
  const EvaluateResult result = evaluate(globals, arguments);
  if (!arguments.output.empty()) write_csv(arguments.output, result.points, result.made);
  if (globals.json)
    print_json(to_json(result));
  else
    tell(globals, result, arguments.output.empty());
  return 0;
}

}  // namespace

void add_evaluate(CommandLine& line) {
  const auto arguments = std::make_shared<EvaluateArguments>();
  Command sub = line.add("evaluate", "Forces approximated from known states at given points");
  sub.runs([arguments](const Globals& globals) { return run_evaluate(globals, *arguments); });
  sub.option("STATES", arguments->states, "State file, or states as CSV").required();
  sub.option("--points", arguments->points, "CSV of positions x,y,z [m]").required().shows("Q.csv");
  sub.option("--method", arguments->method, "Approximation")
      .one_of({"rbf", "trilinear", "tricubic", "deflection", "two-force", "offline-rbf", "rbf-network"})
      .shows_default();
  sub.option("--kernel", arguments->kernel, "Default: quintic with stiffness, else cubic")
      .one_of({"linear", "cubic", "quintic"});
  sub.option("--data", arguments->data, "Default: force+stiffness if the states have it")
      .one_of({"force", "force+stiffness"});
  sub.option(
         "--neighbours", arguments->neighbours,
         "Neighbours: states in a model. Default 25, or 100 for sets without stiffness. By label a model has "
         "at least 16 outside safe regions (20 without stiffness, everywhere), and up to 32 more in a gap; "
         "1 stays 1. For rbf-network: the number of centres")
      .check(above_zero)
      .check([](const std::string& text) {
        const double n = std::strtod(text.c_str(), nullptr);
        return n >= 1 && n <= 100'000 ? "" : "is " + text + ", expected a whole number from 1 to 100000";
      });
  sub.option("--select", arguments->select, "Neighbour rule").one_of({"label", "nearest"}).shows_default();
  sub.option("--spacing", arguments->spacing,
             "h [m]; default: as in the file, else the median distance of states")
      .check(above_zero);
  sub.option("--ridge", arguments->ridge,
             "For noisy states: added to the kernel's diagonal; auto: chosen by leave-one-out")
      .shows("NUMBER|auto")
      .shows_default();
  sub.option("-o,--output", arguments->output, "Forces as CSV").shows("OUT.csv");
}

}  // namespace forefeel
