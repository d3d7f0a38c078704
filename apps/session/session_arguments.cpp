#include "apps/session/session_arguments.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "apps/console/interrupt.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_session.hpp"
#include "apps/scene/spec_text.hpp"
#include "geometry/common/error.hpp"
#include "scheduling/motion/surface_shapes.hpp"

namespace forefeel {
namespace {

template <class T>
T one_of(const std::string& given, const char* option, std::initializer_list<T> values) {
  std::string names;
  for (const T value : values) {
    if (given == name(value)) return value;
    names += (names.empty() ? "" : ", ") + std::string(name(value));
  }
  throw InputError(option, fmt::format("is '{}', expected {}", given, names));
}

}  // namespace

SessionOptions session_options_of(const Globals& globals, const SessionArguments& given, const Scene& scene) {
  SessionOptions options = scene.session;
  options.model.fit = scene.model;
  if (given.motion.clock) {
    if (*given.motion.clock != "real" && *given.motion.clock != "virtual")
      throw InputError("--clock", fmt::format("is '{}', expected real or virtual", *given.motion.clock));
    options.clock.kind = *given.motion.clock == "real" ? Clock::real : Clock::virtual_time;
  }
  if (!given.motion.replay)
    options.motion.device = given.motion.device ? device_from_text(*given.motion.device) : device_of(scene);
  options.workers.cost = given.solving.cost ? cost_from_text(*given.solving.cost) : cost_of(scene);
  if (given.solving.policy) options.planning.policy = part_from_text("policy", *given.solving.policy);
  if (given.motion.predictor) options.motion.predictor = part_from_text("predictor", *given.motion.predictor);
  if (given.solving.workers_kind)
    options.workers.kind = part_from_text("workers", *given.solving.workers_kind);
  options.clock.seconds = given.motion.seconds.value_or(options.clock.seconds);
  // A motion that ends is run to its end if it was asked for on the command line. One from the scene runs no
  // longer than the scene says.
  if (!given.motion.seconds)
    options.clock.length =
        given.motion.device || given.motion.replay ? RunLength::motion : RunLength::shorter;
  options.workers.latency = given.solving.latency.value_or(options.workers.latency);
  options.workers.count = given.solving.workers.value_or(options.workers.count);
  if (given.solving.arrivals) options.planning.arrivals = *given.solving.arrivals;
  if (given.motion.replay) options.motion.replay = *given.motion.replay;
  if (given.switching)
    options.switching.rule =
        one_of(*given.switching, "--switch", {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none});
  if (given.select)
    options.model.fit.select = one_of(*given.select, "--select", {Select::label, Select::nearest});
  options.workers.threads = globals.threads;
  if (globals.seed != 0) options.seed = globals.seed;
  return options;
}

namespace {

// Options that choose what is solved, by which workers and when.
std::vector<std::string> scheduling_options(const SessionArguments& given) {
  std::vector<std::string> options;
  if (given.solving.policy) options.push_back("--policy");
  if (given.motion.predictor) options.push_back("--predictor");
  if (given.solving.workers) options.push_back("--workers");
  if (given.solving.workers_kind) options.push_back("--workers-kind");
  if (given.solving.cost) options.push_back("--cost");
  if (given.solving.latency) options.push_back("--latency");
  return options;
}

// Nothing is solved where states arrive at given times. Options of solving are ignored; a warning says which.
void warn_of_solving(const Globals& globals, const Scene& scene, const SessionArguments& given) {
  if (given.motion.replay || (!given.solving.arrivals && scene.written.arrivals_place.empty())) return;
  const std::string arrivals = given.solving.arrivals ? "--arrivals" : scene.written.arrivals_place.text();
  std::vector<std::string> options = scheduling_options(given);
  if (given.mpi.on) options.push_back("--mpi");
  for (const auto& [key, place] : scene.written.scheduling) options.push_back(place.text());
  if (!options.empty())
    warn(globals, fmt::format("{}: without effect where states arrive at given times ({})",
                              fmt::join(options, ", "), arrivals));
}

void join(const std::shared_ptr<RankPool>& ranks, const SessionArguments& given, SessionOptions& options) {
  if (options.clock.kind != Clock::real)
    throw InputError(
        "--mpi", "has no use under the virtual clock, whose workers are simulated; expected --clock real");
  if (given.solving.workers && *given.solving.workers != ranks->ranks())
    throw InputError("--workers", fmt::format("is {}, but with --mpi the workers are the {} other ranks",
                                              *given.solving.workers, ranks->ranks()));
  options.workers.count = ranks->ranks();
  options.workers.ranks = ranks;
}

// An error in the device, the cost or the box names the scene's file, line and key, unless the command line
// gave it.
InputError at_its_place(const InputError& error, const Scene& scene, const SessionArguments& given,
                        const Globals& globals) {
  if (!error.place().file.empty()) return error;
  const std::string &key = error.place().key, &problem = error.problem();
  const auto of = [&](const char* kind, bool here, const InputPlace& place) {
    return key == kind && !here ? place : InputPlace{};
  };
  if (key.starts_with("session.") || key.starts_with("model.")) {
    const std::string option = key.substr(key.find('.') + 1);
    const std::pair<const char*, bool> options[] = {{"seconds", given.motion.seconds.has_value()},
                                                    {"workers", given.solving.workers.has_value()},
                                                    {"threads", globals.threads > 0},
                                                    {"policy", given.solving.policy.has_value()},
                                                    {"latency", given.solving.latency.has_value()},
                                                    {"predictor", given.motion.predictor.has_value()}};
    for (const auto& [name, here] : options)
      if (here && key == std::string("session.") + name) return {"--" + option, problem};
    for (const std::string& set : globals.set)
      if (set.starts_with(key + "=")) return {InputPlace{.option = "--set", .key = key}, problem};
    return {InputPlace{.file = scene.source.file.string(), .key = key}, problem};
  }
  if (const InputPlace place = of("state_space.box", false, scene.written.box_place); !place.empty())
    return {place, problem};
  InputPlace place = of("device", given.motion.device.has_value(), scene.written.device_place);
  if (place.empty()) place = of("cost", given.solving.cost.has_value(), scene.written.cost_place);
  if (place.empty()) return error;
  const std::optional<std::string>& spec = error.place().value;  // "path:press,speed=x"
  return {place, spec ? fmt::format("'{}' {}", *spec, problem) : problem};
}

}  // namespace

void warn_of_replay(const Globals& globals, const Scene& scene, const SessionArguments& given) {
  if (!given.motion.replay) return;
  std::vector<std::string> vain = scheduling_options(given);
  if (given.motion.device) vain.insert(vain.begin(), "--device");
  for (const auto& [key, place] : scene.written.scheduling)
    if (!place.option.empty()) vain.push_back(place.text());
  if (!vain.empty()) warn(globals, fmt::format("{}: without effect with --replay", fmt::join(vain, ", ")));
}

SessionPlan plan_of(const Globals& globals, const SessionArguments& given, const Scene& scene,
                    const std::shared_ptr<RankPool>& ranks, bool displacements,
                    std::optional<SessionField>& field) {
  try {
    SessionOptions options = session_options_of(globals, given, scene);
    palpate(scene, given.motion.device.has_value(), options);
    if (is_anywhere(scene) && !options.motion.replay) check_on_surface(options.motion.device);
    warn_of_solving(globals, scene, given);
    if (ranks) join(ranks, given, options);
    SessionInput input = session_input(scene);
    input.touched.displacements = input.touched.displacements || displacements;
    field = touch_anywhere(scene, globals, input);
    end_if_interrupted("the session began");
    return make_plan(std::move(input), std::move(options));
  } catch (const InputError& error) {
    throw at_its_place(error, scene, given, globals);
  }
}

}  // namespace forefeel
