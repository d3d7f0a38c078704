#include "apps/generate/generate_sites.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "apps/console/document_keys.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/provenance.hpp"
#include "apps/generate/kept_states.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_fine.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

constexpr std::size_t checked_places = 100;

struct SitesResult {
  std::size_t sites = 0, states = 0, solved = 0, failed = 0, clamped = 0;
  double field_seconds = 0, seconds = 0;
  bool kept = false, interrupted = false;
  FieldErrors error;  // of places whose pad is free of the clamp
  FieldErrors all;
};

const JsonKeys<SitesResult>& sites_keys() {
  using S = SitesResult;
  static const JsonKeys<S> keys{
      {"sites", "", "places of the surface whose jets at rest make the field", &S::sites},
      {"states", "", "solved states in the file, those at rest left out", &S::states},
      {"solved", "", "of this run", &S::solved},
      {"failed", "", "solves that failed", &S::failed},
      {"clamped", "", "states in the file whose pad reaches over the clamp", &S::clamped},
      {"field_seconds", "s", "that making or reading the field took", &S::field_seconds},
      {"field_kept", "", "true: the field was read from the cache", &S::kept},
      {"seconds", "s", "of all", &S::seconds},
      {"error.p50", "1",
       "median of the relative error of the field's force at the states whose pad is free of the clamp; "
       "null: none",
       [](const S& s) { return s.error.p50; }},
      {"error.p95", "1", "95th percentile", [](const S& s) { return s.error.p95; }},
      {"error.max", "1", "largest", [](const S& s) { return s.error.max; }},
      {"error_all.p50", "1", "median over all states", [](const S& s) { return s.all.p50; }},
      {"error_all.p95", "1", "95th percentile over all states", [](const S& s) { return s.all.p95; }},
      {"error_all.max", "1", "largest over all states", [](const S& s) { return s.all.max; }},
      {"interrupted", "", "true: some places are not solved; the same command resumes", &S::interrupted}};
  return keys;
}

StateFileHeader header_of_sites(const Scene& scene, double spacing) {
  StateFileHeader header;
  header.identity = scene.identity;
  header.spacing = spacing;
  header.box = scene.space.box;
  header.notes["scene"] = scene.source.file.string();
  header.notes["provenance"] = json_text(provenance(scene.source.hash));
  return header;
}

// The places that the file does not hold yet.
std::vector<SitedPlace> missing_places(const std::vector<SitedPlace>& places,
                                       const std::vector<State>& known) {
  std::vector<SitedPlace> missing;
  for (const SitedPlace& place : places)
    if (std::ranges::none_of(known, [&](const State& s) {
          return s.at == place.x && s.has_site() && s.site == place.site.at;
        }))
      missing.push_back(place);
  return missing;
}

void solve_missing(const Globals& globals, const Scene& scene, const RestSites& rest,
                   const std::vector<SitedPlace>& missing, KeptStates& kept, std::vector<State>& known,
                   const std::stop_source& stop, SitesResult& result) {
  InterruptWatch watch;
  Progress progress(globals, "generate");
  std::size_t done = 0;
  const auto take = [&](State state, std::size_t) {
    if (watch.raised()) std::stop_source(stop).request_stop();
    ++done;
    (state.usable() ? result.solved : result.failed) += 1;
    known.push_back(state);
    kept.keep(std::move(state));
    progress.show(static_cast<double>(done) / static_cast<double>(missing.size()),
                  fmt::format("{} of {} states", done, missing.size()));
  };
  const int threads = globals.threads > 0 ? globals.threads : omp_get_max_threads();
  solve_places(rest, missing, scene.space.spacing, threads, take, stop.get_token());
  kept.flush();
  result.interrupted = done < missing.size() || kept.failed();
}

void tell_sites(const Globals& globals, const GenerateSites& wanted, const SitesResult& result) {
  say(globals,
      fmt::format("{}: a field of {} sites ({} in {:.2f} s), {} states solved, {} failed, {:.2f} s in all",
                  wanted.output, result.sites, result.kept ? "read" : "made", result.field_seconds,
                  result.solved, result.failed, result.seconds));
  if (result.error.states > 0)
    answer(globals,
           fmt::format("  error of the field at {} of them: p50 {:.2g} %, p95 {:.2g} %, max {:.2g} %",
                       result.error.states, 100 * result.error.p50, 100 * result.error.p95,
                       100 * result.error.max));
  if (result.clamped > 0)
    answer(globals,
           fmt::format("  with the {} whose pad reaches over the clamp: p50 {:.2g} %, p95 {:.2g} %, max "
                       "{:.2g} %",
                       result.clamped, 100 * result.all.p50, 100 * result.all.p95, 100 * result.all.max));
}

}  // namespace

DeclaredTable generate_sites_output() {
  return {"generate_sites.json", "Of generate --json, with contact.anywhere.", declared(sites_keys())};
}

int generate_sites(const Globals& globals, const Scene& scene, const GenerateSites& wanted) {
  const auto start = std::chrono::steady_clock::now();
  const Body& answered = scene.touch.anywhere->fine ? scene.touch.anywhere->fine->first : *scene.body;
  const SurfacePart part = surface_part(wanted.where, answered, "--where");
  const FieldFound found = find_field(scene, globals);
  const RestSites& rest = found.field->rest();
  const std::vector<SitedPlace> places =
      random_places(rest, part, scene.touch.anywhere->depth, checked_places, "--where");
  SitesResult result{.sites = found.field->size(),
                     .field_seconds = found.seconds,
                     .kept = found.kept,
                     .error = {},
                     .all = {}};
  StateFile file =
      StateFile::open_or_create(wanted.output, header_of_sites(scene, found.field->options().spacing));
  std::vector<State> known = file.read_all();
  if (std::ranges::none_of(known, [](const State& s) { return s.has_site() && s.at.isZero(); })) {
    const std::vector<State> at_rest = rest_states(*found.field);
    file.append(at_rest);
    known.insert(known.end(), at_rest.begin(), at_rest.end());
  }
  std::stop_source stop;
  KeptStates kept(std::move(file), known.size(), stop);
  solve_missing(globals, scene, rest, missing_places(places, known), kept, known, stop, result);
  std::vector<State> free_of_clamp, deep;
  for (const State& state : known) {
    if (!state.has_site() || state.at.isZero() || !state.usable()) continue;
    deep.push_back(state);
    if (rest.at(rest.map().nearest(state.site), false).clamped_share > 0)
      ++result.clamped;
    else
      free_of_clamp.push_back(state);
  }
  result.states = deep.size();
  const double floor = scene.session.judging.error_floor;
  result.error = field_errors(*found.field, free_of_clamp, floor);
  result.all = field_errors(*found.field, deep, floor);
  result.seconds = seconds_since(start);
  if (globals.json) print_json(document_of(sites_keys(), result));
  tell_sites(globals, wanted, result);
  if (result.interrupted) {
    warn(globals, kept.failed() ? kept.in_words() : "interrupted; rerun the same command to resume");
    return 1;
  }
  if (wanted.error && !(result.error.p95 <= *wanted.error)) {
    warn(globals, fmt::format("the field errs by {:.2g} % at p95, above --error {:g}; a smaller "
                              "contact.site_spacing or state_space.depth brings it down",
                              100 * result.error.p95, *wanted.error));
    return 1;
  }
  return result.failed > 0 ? 1 : 0;
}

}  // namespace forefeel
