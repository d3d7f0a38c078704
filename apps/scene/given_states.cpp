#include "apps/scene/given_states.hpp"

#include <fmt/format.h>

#include "apps/scene/field_check.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/misleading.hpp"
#include "geometry/states/repeated_states.hpp"
#include "scheduling/workers/ask_body.hpp"
#include "scheduling/workers/reference_service.hpp"

namespace forefeel {
namespace {

std::vector<State> references_of(const Scene& scene, const Globals& globals,
                                 std::span<const State* const> states) {
  SessionInput input = session_input(scene);
  input.touched.displacements = false;
  input.touched.jet = 1;
  ReferenceService references(reference_options(input), globals.threads);
  for (const State* state : states) references.request(state->at);
  std::vector<State> solved;
  for (const State* state : states) solved.push_back(references.get(state->at));
  return solved;
}

// Of the body that a touch anywhere is answered for.
std::vector<State> references_at_sites(const Scene& scene, const Globals& globals,
                                       std::span<const State* const> states) {
  const std::shared_ptr<const SiteField> field = site_field_of(scene, globals);
  std::vector<SitedPlace> places;
  for (const State* state : states)
    places.push_back({.site = field->rest().map().nearest(state->site), .x = state->at});
  std::vector<State> solved(places.size());
  const auto keep_solved = [&](State state, std::size_t i) { solved[i] = std::move(state); };
  solve_places(field->rest(), places, scene.space.spacing, std::max(1, globals.threads), keep_solved, {});
  return solved;
}

void check_sites(const Scene& scene, const std::string& file, std::span<const State> states) {
  if (is_anywhere(scene)) {
    if (std::ranges::all_of(states, &State::has_site)) return;
    throw InputError({.file = file},
                     "has states without a site, expected columns sx,sy,sz beside x,y,z: the scene has "
                     "contact.anywhere");
  }
  if (std::ranges::any_of(states, &State::has_site))
    throw InputError({.file = file},
                     "has sites, expected a scene with contact.anywhere = true, or states of one place");
}

}  // namespace

const char* const foreign_help =
    "Accept states of another or an unknown body; nothing is then solved for the scene's body";

std::string_view name(Belonging belonging) {
  return belonging == Belonging::identity ? "identity" : belonging == Belonging::asked ? "asked" : "foreign";
}

Belonging belonging_of(const Globals& globals, const Scene& scene, const std::string& file,
                       const BodyIdentity& identity, std::span<const State> states, bool foreign,
                       bool may_be_foreign) {
  const std::string way_out = may_be_foreign
                                  ? "expected states of this body, or --foreign to take them knowingly"
                                  : "expected states of this body";
  if (!identity.empty()) {
    const std::string differs = differing_keys(identity, scene.identity);
    if (differs.empty()) {
      if (foreign) warn(globals, fmt::format("--foreign: without effect, {} is of this body", file));
      return Belonging::identity;
    }
    if (foreign) return Belonging::foreign;
    throw InputError({.file = file},
                     fmt::format("belongs to another body, different: {}; {}", differs, way_out));
  }
  if (foreign) return Belonging::foreign;
  check_sites(scene, file, states);
  const double farthest = 2 * bounding_box(scene.body->mesh).size().maxCoeff();
  BodyAnswer answer;
  {
    const Progress progress(globals, "comparing with the body");
    answer = ask_body(states, farthest, [&](std::span<const State* const> asked) {
      return is_anywhere(scene) ? references_at_sites(scene, globals, asked)
                                : references_of(scene, globals, asked);
    });
  }
  if (answer.asked.empty() && !answer.too_far) return Belonging::asked;  // no force to compare
  if (!answer.fits())
    throw InputError({.file = file}, fmt::format("names no body, and does not fit that of {}: {}; {}",
                                                 scene.source.file.string(), in_words(answer), way_out));
  say(globals, fmt::format("{}: names no body; {}, taken as states of {}", file, in_words(answer),
                           scene.source.file.string()));
  return Belonging::asked;
}

GivenStates given_states(const Globals& globals, const Scene& scene, const std::string& file, bool foreign) {
  GivenStates given{.loaded = load_states(file)};
  if (given.loaded.damaged > 0) warn(globals, damage_in_words(file, given.loaded.damaged));
  if (given.loaded.header.identity.empty())
    for (const std::string& line : misleading(given.loaded.states, scene.space.spacing))
      warn(globals, fmt::format("{}: {}", file, line));
  AveragedStates mean = averaged(given.loaded.states);
  if (const std::string line = contradictions_in_words(file, mean.found, given.loaded.states); !line.empty())
    warn(globals, line);
  given.loaded.states = std::move(mean.states);
  given.belonging =
      belonging_of(globals, scene, file, given.loaded.header.identity, given.loaded.states, foreign);
  return given;
}

}  // namespace forefeel
