#include "apps/generate/generate_sites.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <utility>

#include "apps/console/document_keys.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/provenance.hpp"
#include "apps/generate/generate_deep.hpp"
#include "apps/generate/kept_states.hpp"
#include "apps/generate/site_ranks.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/mpi_run.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_fine.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/states/state_file.hpp"

namespace forefeel {
namespace {

constexpr std::size_t checked_places = 100;

struct SitesResult {
  std::size_t sites = 0, jets = 0, states = 0, solved = 0, failed = 0, clamped = 0, through = 0;
  double field_seconds = 0, seconds = 0;
  bool kept = false, interrupted = false;
  FieldErrors error;  // of places whose pad is free of the clamp, and that are not through the body
  FieldErrors all;
  DeepRounds deep;                       // with --error
  std::optional<FarmReport> ranks = {};  // with --mpi
};

const JsonKeys<SitesResult>& sites_keys() {
  using S = SitesResult;
  static const JsonKeys<S> keys{
      {"sites", "", "places of the surface whose jets at rest make the field", &S::sites},
      {"jets", "", "jets at rest in the file beside the field's, of sites with states and of denser ones",
       &S::jets},
      {"states", "", "solved states in the file, those at rest left out", &S::states},
      {"solved", "", "of this run", &S::solved},
      {"failed", "", "solves that failed", &S::failed},
      {"clamped", "", "states in the file whose pad reaches over the clamp", &S::clamped},
      {"through", "", "states in the file that press deeper than the body is thick there", &S::through},
      {"field_seconds", "s", "that making or reading the field took", &S::field_seconds},
      {"field_kept", "", "true: the field was read from the cache", &S::kept},
      {"seconds", "s", "of all", &S::seconds},
      {"error.p50", "1",
       "median of the relative error of the field's force at the states whose pad is free of the clamp and "
       "that press no deeper than the body is thick; null: none",
       [](const S& s) { return s.error.p50; }},
      {"error.p95", "1", "95th percentile", [](const S& s) { return s.error.p95; }},
      {"error.max", "1", "largest", [](const S& s) { return s.error.max; }},
      {"error_all.p50", "1", "median over all states", [](const S& s) { return s.all.p50; }},
      {"error_all.p95", "1", "95th percentile over all states", [](const S& s) { return s.all.p95; }},
      {"error_all.max", "1", "largest over all states", [](const S& s) { return s.all.max; }},
      {"rounds", "", "of --error that added jets or states", [](const S& s) { return s.deep.rounds; }},
      {"error_with_states.p50", "1",
       "with --error: median of the error of field and states at the random places that were solved last, "
       "before they were added, the same ones left out",
       [](const S& s) { return s.deep.error.p50; }},
      {"error_with_states.p95", "1", "95th percentile of that", [](const S& s) { return s.deep.error.p95; }},
      {"error_with_states.max", "1", "largest of that", [](const S& s) { return s.deep.error.max; }},
      {"ranks.solving", "", "with --mpi: ranks that solved",
       [](const S& s) { return s.ranks ? std::optional(s.ranks->ranks) : std::nullopt; }},
      {"ranks.lost", "", "with --mpi: ranks that answered no more",
       [](const S& s) { return s.ranks ? std::optional(s.ranks->lost) : std::nullopt; }},
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

// The file, and what it holds: solves and makes what it does not.
class SitesFile {
 public:
  SitesFile(const Globals& globals, const Scene& scene, const RestSites& rest, StateFile file,
            SitesResult& result)
      : globals_(globals),
        scene_(scene),
        rest_(rest),
        known_(file.read_all()),
        kept_(std::move(file), known_.size(), stop_),
        result_(result) {
    for (std::size_t i = 0; i < known_.size(); ++i) note(i);
    progress_.emplace(globals_, "generate");
  }
  void end() {
    progress_.reset();
    kept_.flush();
  }

  std::vector<State> solve(std::span<const SitedPlace> places) {
    std::vector<SitedPlace> missing;
    for (const SitedPlace& place : places)
      if (!where_.contains(key(place.site.at, place.x))) missing.push_back(place);
    const auto take = [&](State state, std::size_t) {
      look();
      (state.usable() ? result_.solved : result_.failed) += 1;
      add(std::move(state));
      progress_->show(fmt::format("{} states solved, {} failed{}", result_.solved, result_.failed, words_));
    };
    if (ranks_)
      ranks_(missing, take);
    else
      solve_places(rest_, missing, scene_.space.spacing, threads(), take, stop_.get_token());
    kept_.flush();
    std::vector<State> found;
    for (const SitedPlace& place : places)
      if (const auto at = where_.find(key(place.site.at, place.x)); at != where_.end())
        found.push_back(known_[at->second]);
    if (found.size() < places.size() || kept_.failed()) result_.interrupted = true, stop_.request_stop();
    return found;
  }

  // From now on these solve; empty: threads.
  void solve_by(SolvePlaces ranks) { ranks_ = std::move(ranks); }
  void look() {
    if (watch_.raised()) stop_.request_stop();
  }

  std::vector<State> jets(std::span<const SurfacePlace> places) {
    std::vector<SurfacePlace> missing;
    for (const SurfacePlace& place : places)
      if (!where_.contains(key(place.at, Vec3::Zero()))) missing.push_back(place);
    for (State& jet : jets_at(rest_, missing, threads(), stop_.get_token())) add(std::move(jet));
    std::vector<State> found;
    for (const SurfacePlace& place : places)
      if (const auto at = where_.find(key(place.at, Vec3::Zero())); at != where_.end())
        found.push_back(known_[at->second]);
    return found;
  }

  void add(State state) {
    known_.push_back(state);
    note(known_.size() - 1);
    kept_.keep(std::move(state));
  }
  void say_round(int round, double p95) {
    words_ = fmt::format(", p95 {} in round {}", in_percent(p95), round + 1);
  }
  const std::vector<State>& known() const { return known_; }
  const KeptStates& kept() const { return kept_; }
  std::stop_token stop() const { return stop_.get_token(); }
  int threads() const { return globals_.threads > 0 ? globals_.threads : omp_get_max_threads(); }

 private:
  using Key = std::array<double, 6>;
  static Key key(const Vec3& site, const Vec3& x) { return {site[0], site[1], site[2], x[0], x[1], x[2]}; }
  void note(std::size_t i) {
    if (known_[i].has_site()) where_.try_emplace(key(known_[i].site, known_[i].at), i);
  }

  const Globals& globals_;
  const Scene& scene_;
  const RestSites& rest_;
  std::stop_source stop_;
  std::vector<State> known_;
  std::map<Key, std::size_t> where_;
  KeptStates kept_;
  SitesResult& result_;
  std::string words_;
  SolvePlaces ranks_;
  InterruptWatch watch_;
  std::optional<Progress> progress_;
};

DeepRounds refine(const Scene& scene, const GenerateSites& wanted, const SurfacePart& part,
                  const std::shared_ptr<const SiteField>& field, SitesFile& file) {
  return refine_to({.field = field,
                    .places =
                        [&](std::size_t count, unsigned seed) {
                          return random_places(field->rest(), part, scene.touch.anywhere->depth, count,
                                               "--where", seed);
                        },
                    .solve = [&](std::span<const SitedPlace> places) { return file.solve(places); },
                    .jets = [&](std::span<const SurfacePlace> places) { return file.jets(places); },
                    .tell = [&](int round, double p95) { file.say_round(round, p95); },
                    .error = *wanted.error,
                    .floor = scene.session.judging.error_floor,
                    .threads = file.threads(),
                    .stop = file.stop()});
}

// Errors of the field at all states of the file, and counts.
void measure(const Scene& scene, const SiteField& field, const std::vector<State>& known,
             SitesResult& result) {
  const RestSites& rest = field.rest();
  std::vector<State> free_of_clamp, deep;
  std::size_t at_rest = 0;
  for (const State& state : known) {
    at_rest += state.has_site() && state.at.isZero();
    if (!state.has_site() || state.at.isZero() || !state.usable()) continue;
    deep.push_back(state);
    const SurfacePlace place = rest.map().nearest(state.site);
    const SiteRest here = rest.at(place, false);
    const bool through = -state.at.dot(here.normal) > rest.map().thickness(place, here.normal);
    result.through += through;
    result.clamped += here.clamped_share > 0;
    if (!through && !(here.clamped_share > 0)) free_of_clamp.push_back(state);
  }
  result.states = deep.size();
  result.jets = at_rest - std::min(at_rest, field.size());
  const double floor = scene.session.judging.error_floor;
  result.error = field_errors(field, free_of_clamp, floor);
  result.all = field_errors(field, deep, floor);
}

void tell_sites(const Globals& globals, const GenerateSites& wanted, const SitesResult& result) {
  say(globals,
      fmt::format("{}: a field of {} ({} in {:.2f} s), {} solved, {} failed, {:.2f} s in all", wanted.output,
                  counted(result.sites, "site"), result.kept ? "read" : "made", result.field_seconds,
                  counted(result.solved, "state"), result.failed, result.seconds));
  if (result.error.states > 0)
    answer(globals, fmt::format("  error of the field at {} of them: p50 {}, p95 {}, max {}",
                                result.error.states, in_percent(result.error.p50),
                                in_percent(result.error.p95), in_percent(result.error.max)));
  if (result.deep.rounds > 0)
    answer(globals,
           fmt::format("  with {} and {}, at {}: p50 {}, p95 {}, max "
                       "{}",
                       counted(result.jets, "jet"), counted(result.states, "state"),
                       counted(result.deep.error.states, "fresh place"), in_percent(result.deep.error.p50),
                       in_percent(result.deep.error.p95), in_percent(result.deep.error.max)));
  if (result.clamped + result.through > 0)
    answer(globals, fmt::format("  with those whose pad reaches over the clamp, {}, and those through the "
                                "body, {}: p50 {}, p95 {}, max "
                                "{}",
                                result.clamped, result.through, in_percent(result.all.p50),
                                in_percent(result.all.p95), in_percent(result.all.max)));
}

}  // namespace

DeclaredTable generate_sites_output() {
  return {"generate_sites.json", "Of generate --json, with contact.anywhere.", declared(sites_keys())};
}

int generate_sites(const Globals& globals, const Scene& scene, const GenerateSites& wanted, RankPool* ranks) {
  const auto start = std::chrono::steady_clock::now();
  if (ranks) ranks->begin(rank_identity(scene.source.hash), pack_spacing(scene.space.spacing));
  const Body& answered = scene.touch.anywhere->fine ? scene.touch.anywhere->fine->first : *scene.body;
  const SurfacePart part = surface_part(wanted.where, answered, "--where");
  const FieldFound found = find_field(scene, globals);
  const std::shared_ptr<const SiteField>& field = found.field;
  const std::vector<SitedPlace> places =
      random_places(field->rest(), part, scene.touch.anywhere->depth, checked_places, "--where");
  SitesResult result{.sites = field->size(),
                     .field_seconds = found.seconds,
                     .kept = found.kept,
                     .error = {},
                     .all = {},
                     .deep = {}};
  SitesFile file(globals, scene, field->rest(),
                 StateFile::open_or_create(wanted.output, header_of_sites(scene, field->options().spacing)),
                 result);
  if (std::ranges::none_of(file.known(), [](const State& s) { return s.has_site() && s.at.isZero(); }))
    for (State& state : rest_states(*field)) file.add(std::move(state));
  const auto work = [&] {
    if (wanted.error)
      result.deep = refine(scene, wanted, part, field, file);
    else
      file.solve(places);
  };
  if (ranks)
    result.ranks = with_ranks(*ranks, field->rest_shared(), scene.space.spacing,
                              {.stop = file.stop(),
                               .tick = [&] { file.look(); },
                               .note =
                                   [&](const std::string& line) {
                                     warn(globals, line);
                                     flush_warnings();
                                   }},
                              [&](const SolvePlaces& solve) {
                                file.solve_by(solve);
                                work();
                              });
  else
    work();
  file.end();
  measure(scene, *field, file.known(), result);
  result.seconds = seconds_since(start);
  if (globals.json) print_json(document_of(sites_keys(), result));
  tell_sites(globals, wanted, result);
  if (result.interrupted) {
    warn(globals,
         file.kept().failed() ? file.kept().in_words() : "interrupted; rerun the same command to resume");
    return 1;
  }
  if (wanted.error && !(result.deep.error.p95 <= *wanted.error)) {
    warn(globals,
         fmt::format("field and states err by {} at p95, above --error {:g}, and more states no longer "
                     "help; a smaller contact.site_spacing or state_space.depth brings it down",
                     in_percent(result.deep.error.p95), *wanted.error));
    return 1;
  }
  return result.failed > 0 ? 1 : 0;
}

}  // namespace forefeel
