#include "apps/generate/generate_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stop_token>
#include <thread>

#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/generate/kept_states.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/coverage/design.hpp"
#include "geometry/states/check_solves.hpp"
#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_outcome.hpp"
#include "scheduling/placement/placement.hpp"

namespace forefeel {
namespace {

Json quantiles(const ErrorQuantiles& q) {
  return json_numbers({q.p50, q.p95, q.max});
}

// States with inverted elements (state_outcome.hpp): all in the file, and those of this run.
struct Inverted {
  std::size_t all = 0, now = 0;
};

struct Placed {
  const PlacementReport& report;
  const Inverted& inverted;
  std::optional<double> error;  // E of --error
  const MeshError& mesh;
};

Json truth_holds(const Placed& p) {
  const bool known = p.report.truth.unsolved == 0 && p.report.truth.samples > 0;
  return known ? Json(p.report.truth.holds) : Json();
}

JsonKeys<PlacementTruth> truth_keys() {
  using T = PlacementTruth;
  return {{"p50,p95,max", "1", "of the error at tight solves", [](const T& t) { return quantiles(t.error); }},
          {"held", "1", "the least E that these stay below", [](const T& t) { return t.error.held(); }},
          {"samples", "", "tight solves", &T::samples},
          {"on_surface", "", "of these, on the surface of the box", &T::on_surface},
          {"failed", "", "tight solves that failed", &T::failed},
          {"unsolved", "", "positions without a tight solve", &T::unsolved},
          {"fresh", "", "true: at positions that the placement has not seen", &T::is_fresh}};
}

const JsonKeys<Placed>& placement_keys() {
  using P = Placed;
  static const JsonKeys<P> keys{
      {"states", "", "usable states in the file", [](const P& p) { return p.report.states; }},
      {"most_states", "", "of a full lattice, or of the design",
       [](const P& p) { return p.report.most_states; }},
      {"solved", "", "of this run", [](const P& p) { return p.report.solved - p.inverted.now; }},
      {"inverted", "", "states with inverted elements in the file",
       [](const P& p) { return p.inverted.all; }},
      {"failed", "", "solves that failed", [](const P& p) { return p.report.failed; }},
      {"resumed", "", "states that were in the file before", [](const P& p) { return p.report.resumed; }},
      {"seconds", "s", "time of the run", [](const P& p) { return p.report.seconds; }},
      {"threads", "", "that solved", [](const P& p) { return p.report.threads; }},
      {"error", "1", "E of --error", [](const P& p) { return p.error ? number(*p.error) : Json(); }},
      json_part<P>(mesh_error_keys(), [](const P& p) { return &p.mesh; }),
      {"error_estimate", "1", "the least E that the estimate stays below",
       [](const P& p) { return p.report.estimate.held(); }},
      {"error_estimate_quantiles.p50,p95,max", "1", "of the estimate over the box",
       [](const P& p) { return quantiles(p.report.estimate); }},
      json_object<P>("error_true", truth_keys(), "", [](const P& p) { return &p.report.truth; }),
      {"linear", "", "true: the body is linear, three solves give all",
       [](const P& p) { return p.report.linear; }},
      {"estimate_holds", "", "true: the estimate is below E",
       [](const P& p) { return p.error ? Json(p.report.estimate_holds) : Json(); }},
      {"truth_holds", "", "true: the errors at tight solves are below E; null: not known", truth_holds},
      {"interrupted", "", "true: the same command resumes", [](const P& p) { return p.report.stopped; }}};
  return keys;
}

std::string in_words(const ErrorQuantiles& q) {
  return fmt::format("p50 {}, p95 {}, max {}", in_percent(q.p50), in_percent(q.p95), in_percent(q.max));
}

// There are two phases, which may alternate several times. In the first, the number of states needed is not known
// beforehand, so the line shows the error reached and no remaining time. In the second, it counts the solves.
void show(Progress& progress, const PlacementProgress& p, std::optional<double> wanted) {
  if (p.truth_total > 0) {
    progress.phase("generate: checking the error");
    progress.show(static_cast<double>(p.truth_done) / static_cast<double>(p.truth_total),
                  fmt::format("{} of {} tight solves, {} states", p.truth_done, p.truth_total, p.states));
    return;
  }
  progress.phase("generate: placing states");
  std::string states = fmt::format("{} of {}{}", p.states, wanted ? "at most " : "", p.most_states);
  if (std::isfinite(p.estimate)) states += fmt::format(", estimated error {:.3g} %", 100 * p.estimate);
  if (std::isfinite(p.estimate) && wanted) states += fmt::format(" of {:.3g} % wanted", 100 * *wanted);
  progress.show(states);
}

void tell(const Globals& globals, const PlacementReport& report, const Inverted& inverted,
          const MeshError& mesh, const std::string& output) {
  const bool mesh_first = mesh.error > report.estimate.held();
  if (mesh_first) say(globals, "attention: " + discretisation_line(mesh, report.estimate.held()));
  say(globals, fmt::format("{}: {}{}, {} solved in {:.2f} s, {} there before, {} failed{}", output,
                           counted(report.states, "state"), inverted_in_words(inverted.all),
                           report.solved - inverted.now, report.seconds, report.resumed, report.failed,
                           report.linear ? "; linear: three solves give the whole state space" : ""));
  say(globals, fmt::format("error estimated over the box: {}", in_words(report.estimate)));
  if (report.truth.samples > 0)
    say(globals, fmt::format("true error at {}, the largest also at {} on the faces of the box: {}{}{}",
                             counted(report.truth.samples, "random position"), report.truth.on_surface,
                             in_words(report.truth.error),
                             report.truth.is_fresh ? "" : " (some of them became states)",
                             report.truth.unsolved > 0
                                 ? "; " + counted(report.truth.unsolved, "was", "were") + " left unsolved"
                                 : ""));
  if (!mesh_first) say(globals, discretisation_line(mesh, report.estimate.held()));
}

constexpr double never_held = 1e-300;  // an error that no model of states reaches

// Why the result is incomplete; empty if it is complete.
std::string complaint(const PlacementReport& report, std::optional<double> wanted,
                      const StateSpaceOptions& space) {
  if (report.stopped) return "interrupted; rerun the same command to resume";
  if (!wanted) return {};
  const double error = *wanted;
  if (!report.estimate_holds && report.states >= report.most_states) {
    // Rest and the eight corners of the box are tried on any lattice.
    const std::size_t positions = lattice(space.box, space.spacing).size();
    const std::string why =
        positions >= report.most_states
            ? fmt::format("as many as the lattice of {:g} m has positions in the box", space.spacing)
            : fmt::format("the fewest that are tried, for the lattice of {:g} m has {} in the box",
                          space.spacing, positions == 0 ? "no position" : counted(positions, "position"));
    return fmt::format("estimated error {:.3g} > {:.3g} with {}, {}; reduce the spacing",
                       report.estimate.held(), error, counted(report.states, "state"), why);
  }
  if (!report.estimate_holds)
    return fmt::format("with {} the estimated error is {:.3g}, not {:.3g}; {} failed",
                       counted(report.states, "state"), report.estimate.held(), error,
                       counted(report.failed, "solve"));
  if (!report.truth.holds)
    return fmt::format("the true error of {:.3g} at {} is above {:.3g}", report.truth.error.held(),
                       counted(report.truth.samples + report.truth.on_surface, "position"), error);
  return {};
}

}  // namespace

DeclaredTable placement_output() {
  return {"generate_error.json", "Of generate --error --json.", declared(placement_keys())};
}

void check_generate_to_error(const Scene& scene) {
  try {
    for_states(scene.model, lattice(scene.space.box, scene.space.spacing).size());
  } catch (const InputError& error) {
    throw InputError({.file = scene.source.file.string(), .key = error.place().key}, error.problem());
  }
}

int generate_to_error(const Globals& globals, const Scene& scene, StateFile file, const std::string& output,
                      std::optional<double> error) {
  PlacementOptions options;
  options.error = error.value_or(never_held);
  if (!error)
    options.max_states = design_size(scene.space.box, scene.space.spacing), options.truth_samples = 0;
  options.space = scene.space;
  options.estimate.model = scene.model;
  options.estimate.floor = scene.session.judging.error_floor;
  options.seed = globals.seed;
  options.threads = globals.threads;
  options.want_displacements = scene.kept.displacements;
  options.jet = scene.kept.jet;
  std::stop_source stop;
  options.stop = stop.get_token();

  std::optional<Progress> progress(std::in_place, globals, "generate");
  const InterruptWatch watch;                               // until the result is told
  std::jthread listener([&](const std::stop_token& done) {  // also between two lines of progress
    for (; !done.stop_requested(); std::this_thread::sleep_for(std::chrono::milliseconds(50)))
      if (watch.raised()) stop.request_stop();
  });
  const std::vector<State> known = file.read_all();
  KeptStates kept(std::move(file), known.size(), stop);
  Inverted inverted{.all = static_cast<std::size_t>(std::ranges::count_if(known, has_inverted_elements))};
  PlacementReport report = place_states(
      scene.body, options, known,
      [&](State state) {
        inverted.now += has_inverted_elements(state);
        inverted.all += has_inverted_elements(state);
        kept.keep(std::move(state));
      },
      [&](const PlacementProgress& p) { show(*progress, p, error); });
  kept.flush();
  if (kept.failed()) {
    const std::size_t before = report.states - report.solved, inverted_before = inverted.all - inverted.now;
    kept.correct(report.solved, report.failed, inverted.now);
    report.states = before + report.solved;
    inverted.all = inverted_before + inverted.now;
  } else if (!report.truth.checks.empty()) {
    keep_checks(output, report.truth.checks);
  }
  progress->phase("generate: the mesh itself");
  const MeshError mesh = MeshErrorTask(scene, MeshErrorTask::When::at_the_end).get();
  listener = {};
  progress.reset();

  if (globals.json) print_json(document_of(placement_keys(), Placed{report, inverted, error, mesh}));
  tell(globals, report, inverted, mesh, output);
  const std::string why = kept.failed() ? kept.in_words() : complaint(report, error, scene.space);
  if (why.empty()) return 0;
  warn(globals, why);
  return 1;
}

}  // namespace forefeel
