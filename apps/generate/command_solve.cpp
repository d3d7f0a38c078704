// forefeel solve SCENE (--at=X,Y,Z)… | --points F.csv [-o OUT.csv]: tight solves on the reference branch.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/values.hpp"
#include "apps/generate/solve_all.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_outcome.hpp"
#include "solver/body/fine_jet.hpp"
#include "solver/equilibrium/mesh_error.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {
namespace {

struct SolveArguments {
  std::string scene;
  std::vector<std::string> at;
  std::string site;  // of a pad anywhere
  std::string points, output;
  bool discretisation_error = false;
  std::optional<int> jet;  // order
};

std::vector<Vec3> wanted_points(const SolveArguments& arguments) {
  std::vector<Vec3> points;
  for (const std::string& text : arguments.at) points.push_back(parse_vector(text, "--at"));
  if (!arguments.points.empty())
    for (const Vec3& x : read_points_csv(arguments.points)) points.push_back(x);
  if (points.empty()) throw InputError("solve", "no position, expected --at=X,Y,Z or --points FILE");
  for (const Vec3& x : points)
    if (!x.allFinite()) throw InputError("solve", "a position is not finite, expected three finite numbers");
  return points;
}

// Refuses positions where no hand takes the body, usually because of another unit or a mistyped exponent: the solves
// would take long and fail. As for recorded motions.
void check_reach(const std::vector<Vec3>& points, double farthest) {
  for (const Vec3& x : points)
    if (!(x.stableNorm() <= farthest))
      throw InputError("solve", fmt::format("the position ({:g}, {:g}, {:g}) m {}", x[0], x[1], x[2],
                                            too_far(x.stableNorm(), farthest)));
}

// Error of the mesh itself at each position (solver/equilibrium/mesh_error.hpp).
std::vector<ForceError> discretisation_errors(const Scene& scene, const std::vector<SolveOutcome>& outcomes) {
  std::vector<State> states;
  for (const SolveOutcome& outcome : outcomes) states.push_back(outcome.state);
  return mesh_errors(*scene.body, states, scene.space.spacing);
}

// Before anything is solved: a finer body that no memory holds.
void check_finer(const Body& body) {
  if (body.fine) return;
  const std::int64_t nodes = nodes_of_finer(body), most = MeshErrorOptions().most_nodes;
  if (nodes > most)
    throw InputError(
        "--discretisation-error",
        fmt::format("needs {} with about {} nodes, expected at most {}", finer_in_words(body), nodes, most));
}

// Result of `forefeel solve`, in the order of the positions.
struct SolveResult {
  std::optional<SitedBody> sited;  // with --site
  std::vector<SolveOutcome> outcomes;
  std::vector<ForceError> discretisation_errors;  // relative; empty unless requested
  int jet = 1;                                    // order of the force that was asked for

  std::size_t failed() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        outcomes, [](const SolveOutcome& o) { return o.state.solve.status != SolveStatus::converged; }));
  }
  std::size_t inverted() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        outcomes, [](const SolveOutcome& o) { return has_inverted_elements(o.state); }));
  }
};

SolveResult solve(const Globals& globals, const SolveArguments& arguments, const Scene& scene,
                  const std::vector<Vec3>& points, const std::optional<Vec3>& site) {
  const int jet = arguments.jet.value_or(scene.kept.jet);
  SolveResult result{.sited = {},
                     .outcomes = solve_all(scene, points, site, jet, globals),
                     .discretisation_errors = {},
                     .jet = jet};
  if (!arguments.discretisation_error) return result;
  result.discretisation_errors = discretisation_errors(scene, result.outcomes);
  for (std::size_t i = 0; i < result.outcomes.size(); ++i) {
    SolveOutcome& outcome = result.outcomes[i];
    std::string why = why_no_error(*scene.body, outcome.state, result.discretisation_errors[i]);
    if (!why.empty()) outcome.warnings.push_back(std::move(why));
  }
  return result;
}

// One entry of `states`.
struct SolvedState {
  const State& state;
  const std::vector<std::string>& warnings;
  bool with_jet;  // one was asked for
  const SitedBody* sited = nullptr;
  std::optional<ForceError> mesh = {};
};

std::vector<SolvedState> solved_states(const SolveResult& result) {
  std::vector<SolvedState> all;
  for (std::size_t i = 0; i < result.outcomes.size(); ++i) {
    all.push_back({result.outcomes[i].state, result.outcomes[i].warnings, result.jet > 1,
                   result.sited ? &*result.sited : nullptr});
    if (!result.discretisation_errors.empty()) all.back().mesh = result.discretisation_errors[i];
  }
  return all;
}

Json rows_of(const Mat3& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(vector3(Vec3(matrix.row(i).transpose())));
  return rows;
}

// The coefficients of the jet's own order alone; null where the state has no jet.
JsonKey<SolvedState> jet_key() {
  std::vector<Declared> rows;
  constexpr std::array<const char*, 5> units{"", "", "N/m^2", "N/m^3", "N/m^4"};
  for (int order = 2; order <= most_jet_order; ++order) {
    const auto begin = static_cast<std::ptrdiff_t>(jet_terms_of_order(order - 1)),
               end = static_cast<std::ptrdiff_t>(jet_terms_of_order(order));
    rows.push_back(
        {fmt::format("jet.{}", fmt::join(jet_names().begin() + begin, jet_names().begin() + end, ",")),
         units[static_cast<std::size_t>(order)], "",
         fmt::format("with --jet {}{}: coefficients of dx^a dy^b dz^c in the energy", order,
                     order < most_jet_order ? " and above" : "")});
  }
  rows.push_back(
      {"jet.limit", "m", "",
       "with --jet: distance to which the jet keeps the material within its limit; null: everywhere"});
  return {std::move(rows), [](Json& document, const SolvedState& s) {
            if (!s.with_jet) return;
            Json& jet = document["jet"] = nullptr;
            if (!s.state.jet) return;
            const EnergyJet& of = *s.state.jet;
            for (std::size_t i = 0; i < jet_terms_of_order(of.order); ++i)
              jet[jet_names()[i]] = number(of.coefficients[i]);
            jet["limit"] = number(of.limit);
          }};
}

const JsonKeys<SolveResult>& solve_keys() {
  using S = SolvedState;
  static const JsonKeys<S> of_state{
      {"at", "m", "HIP position", [](const S& s) { return s.state.at; }},
      {"site", "m", "with --site: place of the pad on the surface, from which at counts",
       [](const S& s) { return s.sited ? std::optional(s.sited->body->pad->site) : std::nullopt; }},
      {"clamped_share", "1", "with --site: share of the pad's springs that pull on clamped nodes",
       [](const S& s) { return s.sited ? std::optional(s.sited->clamped_share) : std::nullopt; }},
      {"thickness", "m", "with --site: of the body at rest under the pad, against its normal",
       [](const S& s) { return s.sited ? std::optional(s.sited->thickness) : std::nullopt; }},
      {"force", "N", "force of the body on the tip", [](const S& s) { return s.state.force; }},
      {"stiffness", "N/m", "rows of K = -df/dx", [](const S& s) { return rows_of(s.state.stiffness); }},
      {"energy", "J", "stored energy", [](const S& s) { return s.state.energy; }},
      jet_key(),
      {"converged", "", "false: not an equilibrium, or one with inverted elements",
       [](const S& s) { return outcome(s.state) == SolveStatus::converged; }},
      {"status", "", "converged, diverged, stalled, inverted or cancelled",
       [](const S& s) { return name(outcome(s.state)); }},
      {"iterations", "", "Newton iterations", [](const S& s) { return s.state.solve.iterations; }},
      {"residual", "1", "relative to the force", [](const S& s) { return s.state.solve.residual; }},
      {"seconds", "s", "time of the solve", [](const S& s) { return s.state.solve.seconds; }},
      {"min_jacobian", "1", "least det F of all elements",
       [](const S& s) { return s.state.solve.min_jacobian; }},
      {"multivalued", "", "true: another path ends at another equilibrium",
       [](const S& s) { return s.state.solve.multivalued; }},
      {"warnings", "", "list of lines", [](const S& s) { return s.warnings; }},
      {"discretisation_error", "1",
       "with --discretisation-error: what the mesh itself gets wrong, relative; null: not measured",
       [](const S& s) { return s.mesh ? std::optional(s.mesh->error) : std::nullopt; }},
      {"discretisation_interval", "1",
       "with --discretisation-error: [low, high], an interval that holds the true error; null: not known",
       [](const S& s) {
         return s.mesh ? std::optional(json_numbers({s.mesh->low, s.mesh->high})) : std::nullopt;
       }}};
  static const JsonKeys<SolveResult> keys{json_list<SolveResult>("states", of_state, solved_states)};
  return keys;
}

std::string line_for(const State& s) {
  return fmt::format(
      "x = ({:.6g}, {:.6g}, {:.6g}) m  f = ({:.6g}, {:.6g}, {:.6g}) N  W = {:.6g} J  {} in {} iterations, "
      "{:.1f} ms, least J {:.3f}{}",
      s.at[0], s.at[1], s.at[2], s.force[0] + 0.0, s.force[1] + 0.0, s.force[2] + 0.0,  // not -0
      s.energy, name(outcome(s)), s.solve.iterations, 1e3 * s.solve.seconds, s.solve.min_jacobian,
      s.solve.multivalued ? ", multivalued" : "");
}

std::string in_words(const EnergyJet* jet) {
  if (!jet) return ", no jet";
  return fmt::format(
      ", jet of order {}, {}", jet->order,
      std::isfinite(jet->limit) ? fmt::format("limit {:.3g} mm", 1e3 * jet->limit) : "without a limit");
}

std::string in_words(const ForceError& mesh) {
  if (!std::isfinite(mesh.error)) return ", discretisation error not known";
  return fmt::format(", discretisation error {:.1f} %", 100 * mesh.error) +
         (std::isfinite(mesh.high)
              ? fmt::format(", between {:.1f} % and {:.1f} %", 100 * mesh.low, 100 * mesh.high)
              : "");
}

void tell(const Globals& globals, const SolveResult& result) {
  for (std::size_t i = 0; i < result.outcomes.size(); ++i) {
    std::string line = line_for(result.outcomes[i].state);
    if (result.jet > 1) line += in_words(result.outcomes[i].state.jet.get());
    if (!result.discretisation_errors.empty()) line += in_words(result.discretisation_errors[i]);
    answer(globals, line);
  }
}

void write_output(const std::string& file, const SolveResult& result) {
  std::vector<State> states;
  for (const SolveOutcome& outcome : result.outcomes) states.push_back(outcome.state);
  write_states_csv(file, states);
}

// The scene, with its pad at --site.
Scene read_scene(const Globals& globals, const SolveArguments& arguments, std::optional<SitedBody>& sited) {
  std::optional<Vec3> site;
  if (!arguments.site.empty()) site = parse_vector(arguments.site, "--site");
  if (site && !site->allFinite())
    throw InputError("--site", "is not finite, expected three finite numbers [m]");
  if (site && !arguments.output.empty())
    throw InputError("-o", "a file of states holds those of one place, expected --json beside --site");
  Scene scene = load_scene_with_sites(arguments.scene, globals.set, {.spacing = false});
  if (site && !is_anywhere(scene))
    throw InputError("--site",
                     "the scene's contact has a place, expected a scene with contact.anywhere = true");
  if (!site && is_anywhere(scene))
    throw InputError("--site", "missing, expected X,Y,Z, where the pad of contact.anywhere is put");
  if (!site) return scene;
  sited = put_at(scene, *site, globals.quiet);
  scene.body = sited->body;
  return scene;
}

int run_solve(const Globals& globals, const SolveArguments& arguments) {
  const std::vector<Vec3> points = wanted_points(arguments);
  if (!arguments.output.empty()) check_writable(arguments.output, {arguments.scene, arguments.points});
  std::optional<SitedBody> sited;
  const Scene scene = read_scene(globals, arguments, sited);
  check_reach(points, 2 * longest_side(scene.body->mesh));
  if (arguments.discretisation_error) check_finer(*scene.body);
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  if (scene.spacing.automatic)
    say(globals,
        fmt::format(
            "spacing \"auto\" is not measured, since a solve needs none: continuation steps of {:.3g} mm",
            1e3 * scene.space.spacing));
  if (sited)
    for (const std::string& warning : sited->warnings) warn(globals, warning);
  for (const Vec3& x : points)
    if (const auto line = sited ? sited->beyond(x) : std::nullopt) warn(globals, *line);
  if (const FineJet* fine = scene.body->fine.get())
    for (const Vec3& x : points)
      if (x.norm() > FineJet::trusted_share * fine->radius())
        warn(globals,
             fmt::format(
                 "({:g}, {:g}, {:g}): the fine body corrects forces to {:.3g} mm from rest; beyond, the "
                 "force is more and more that of the coarse mesh",
                 x[0], x[1], x[2], 1e3 * FineJet::trusted_share * fine->radius()));
  SolveResult result =
      solve(globals, arguments, scene, points, sited ? std::optional(sited->body->pad->site) : std::nullopt);
  result.sited = sited;
  for (const SolveOutcome& outcome : result.outcomes)
    for (const std::string& warning : outcome.warnings)
      warn(globals, fmt::format("({:.6g}, {:.6g}, {:.6g}): {}", outcome.state.at[0], outcome.state.at[1],
                                outcome.state.at[2], warning));
  if (!arguments.output.empty()) write_output(arguments.output, result);
  if (globals.json) print_json(document_of(solve_keys(), result));
  const bool in_file = globals.quiet && !arguments.output.empty();
  if (!globals.json && !in_file) tell(globals, result);
  if (result.inverted() > 0)
    warn(globals, fmt::format("{} of {} states have inverted elements: they do not count as converged",
                              result.inverted(), result.outcomes.size()));
  if (result.failed() > 0)
    warn(globals, fmt::format("{} of {} states did not converge", result.failed(), result.outcomes.size()));
  return result.failed() + result.inverted() > 0 ? 1 : 0;
}

}  // namespace

DeclaredTable solve_output() {
  return {"solve.json", "Of solve --json.", declared(solve_keys())};
}

void add_solve(CommandLine& line) {
  const auto arguments = std::make_shared<SolveArguments>();
  Command sub = line.add(
      "solve", "Exact forces at given positions: the equilibria that the body reaches straight from rest");
  sub.runs([arguments](const Globals& globals) { return run_solve(globals, *arguments); });
  sub.option("SCENE", arguments->scene, "Scene (TOML)").required();
  const Option at = sub.option("--at", arguments->at,
                               "Position of the HIP (haptic interaction point, the tip), from rest [m]; "
                               "repeat --at for more positions")
                        .takes_one()
                        .shows("X,Y,Z");
  sub.option("--site", arguments->site,
             "Where the pad is put: the place of the surface nearest to this [m]; of a scene with "
             "contact.anywhere")
      .shows("X,Y,Z");
  sub.option("--points", arguments->points, "CSV of positions x,y,z [m]").shows("F.csv").excludes(at);
  sub.flag(
      "--discretisation-error", arguments->discretisation_error,
      "Estimate the error of the mesh: solve a finer body too (quadratic elements; where they are quadratic "
      "already, on a mesh of half the size), and compare");
  sub.option(
         "--jet", arguments->jet,
         "Also the energy jet of each state: the force about it to this order (2, 3 or 4), and how far the "
         "material allows it; usually state_space.jet")
      .between(2, most_jet_order)
      .shows("ORDER");
  sub.option("-o,--output", arguments->output, "States as CSV").shows("OUT.csv");
}

}  // namespace forefeel
