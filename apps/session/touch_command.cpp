#include "apps/session/touch_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <variant>

#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/json_text.hpp"
#include "apps/console/provenance.hpp"
#include "apps/scene/field_check.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_fine.hpp"
#include "apps/session/session_folder.hpp"
#include "apps/session/touch_report.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/touch/touch_files.hpp"
#include "scheduling/touch/touch_session.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

void refuse_options(const SessionArguments& given) {
  const auto refuse = [](bool is_given, const char* option, const char* expected) {
    if (is_given)
      throw InputError(option, fmt::format("is for one place, expected {} with contact.anywhere", expected));
  };
  refuse(given.states.foreign, "--foreign", "--states of this body");
  refuse(given.states.extend, "--extend", "--states, and new states in RUN/session.states");
  refuse(given.solving.arrivals.has_value(), "--arrivals", "--states");
  refuse(given.motion.replay.has_value(), "--replay", "--device trace:RUN/frames.csv");
  refuse(given.shape_rate.has_value(), "--shape-rate", "none");
  refuse(given.select.has_value(), "--select", "none");
  refuse(given.solving.workers_kind.has_value(), "--workers-kind", "threads");
  refuse(!given.figures.formats.empty(), "--figures", "report.html");
}

// Palpation where neither the scene nor the command line says more: pressing at one place is no use of such a scene,
// and a hand's usual target.
SessionOptions touch_options(const Globals& globals, const SessionArguments& given, const Scene& scene) {
  SessionOptions options = session_options_of(globals, given, scene);
  if (!given.motion.device && !scene.written.device)
    options.motion.device = DeviceSpec(PathMotion{.path = PathName::palpation});
  if (const auto* hand = std::get_if<HandMotion>(&options.motion.device.motion());
      hand && hand->target.path == PathName::press) {
    HandMotion palpating = *hand;
    palpating.target.path = PathName::palpation;
    options.motion.device = DeviceSpec(palpating);
  }
  return options;
}

DrawPlaces draw_from(const RestSites& rest) {
  return [&rest](const std::string& text, std::size_t count, std::uint64_t seed) {
    constexpr int most_tries = 20'000;
    const SurfacePart part = surface_part(text, rest.body(), "device: where");
    std::mt19937_64 random(seed + 1);
    std::vector<SurfacePlace> places;
    for (int tries = 0; places.size() < count && tries < most_tries; ++tries) {
      const SurfacePlace place = rest.map().random(random);
      if (holds(part, rest.map(), place) && !(rest.at(place, false).clamped_share > 0))
        places.push_back(place);
    }
    if (places.size() < count)
      throw InputError(
          "device: where",
          fmt::format("is '{}', which holds no surface away from the clamp, expected some", text));
    return places;
  };
}

StateSpaceOptions space_of_tips(const RestSites& rest, double spacing) {
  StateSpaceOptions tips;
  tips.spacing = spacing;
  tips.box = {Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (const Vec3& node : rest.body().mesh.nodes)
    tips.box.low = tips.box.low.cwiseMin(node), tips.box.high = tips.box.high.cwiseMax(node);
  return tips;
}

TouchSessionInput touch_input(const Globals& globals, const SessionArguments& given, const Scene& scene,
                              const SiteField& field, std::shared_ptr<const SiteField> shared) {
  const RestSites& rest = field.rest();
  TouchSessionInput input{.task = {.field = std::move(shared),
                                   .grid = std::make_shared<const SurfaceGrid>(rest.map()),
                                   .patches = {},
                                   .tips = space_of_tips(rest, scene.space.spacing),
                                   .depth = scene.touch.anywhere->depth,
                                   .friction = scene.touch.anywhere->friction,
                                   .tolerance = scene.spacing.tolerance,
                                   .floor = scene.session.judging.error_floor},
                          .site_spacing = field.options().spacing,
                          .identity = scene.identity,
                          .viscosity = scene.touch.viscosity,
                          .draw = draw_from(rest),
                          .known = {},
                          .folder = fs::absolute(scene.source.file).parent_path(),
                          .states = fs::path(given.output) / "session.states",
                          .ranks = {}};
  if (given.states.file.empty()) return input;
  GivenStates known = given_states(globals, scene, given.states.file, false);
  // Files of `generate` hold the field's own jets too.
  const auto is_of_field = [&](const State& state) {
    if (!state.at.isZero(0)) return false;
    for (std::size_t i = 0; i < field.size(); ++i)
      if ((field.place(i).at - state.site).norm() < 1e-9) return true;
    return false;
  };
  for (State& state : known.loaded.states)
    if (state.usable() && state.has_site() && !is_of_field(state)) input.known.push_back(std::move(state));
  return input;
}

std::string share_of_touch(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g} %", 100 * value) : "unknown";
}

void tell_touch(const Globals& globals, const TouchSummary& s, const fs::path& run) {
  say(globals,
      fmt::format(
          "field of {} sites {} in {:.2f} s, its facets in {:.2f} s; {} jets at the hand's place, {} states "
          "solved, {} failed",
          s.field.sites, s.field.kept ? "read" : "made", s.field.seconds, s.field.patches, s.states.jets,
          s.states.solved, s.states.failed));
  say(globals, fmt::format("{} touches, {} of {} frames; slid {:.3g} m, lost {:.3g} J; force trusted in {}",
                           s.touch.count, share_of_touch(s.touch.time), s.frames, s.touch.slid, s.touch.lost,
                           share_of_touch(s.time_trusted)));
  say(globals,
      fmt::format("error of the rendered force at {} samples: p50 {}, p95 {}, max {}; within the JND {}; "
                  "{} first visits {}",
                  s.samples.samples, share_of_touch(s.samples.p50), share_of_touch(s.samples.p95),
                  share_of_touch(s.samples.max), share_of_touch(s.samples.within_jnd), s.first_visit.samples,
                  share_of_touch(s.first_visit.within_jnd)));
  if (s.references_failed > 0)
    say(globals, fmt::format("{} samples have no tight solve to compare with", s.references_failed));
  for (const std::string& note : s.notes) say(globals, note);
  say(globals, fmt::format("report: {}", (run / "report.html").string()));
}

}  // namespace

int run_touch_command(const Globals& globals, const SessionArguments& given, const Scene& scene,
                      const std::function<std::shared_ptr<RankPool>()>& gather) {
  refuse_options(given);
  const fs::path run = given.output;
  SessionOptions options = touch_options(globals, given, scene);
  const FieldFound found = find_field(scene, globals);
  end_if_interrupted("the session began");
  TouchSessionInput input = touch_input(globals, given, scene, *found.field, found.field);
  check_touch_session(input, options);
  if (gather) {
    if (options.clock.kind != Clock::real)
      throw InputError("--mpi", "needs other processes that solve, expected --clock real");
    input.ranks = gather();
    options.workers.count = input.ranks->taking_jobs();
  }
  const auto start = std::chrono::steady_clock::now();
  input.task.patches = find_patches(scene, found.field, globals);
  const double patches = seconds_since(start);
  end_if_interrupted("the session began");
  claim_run_folder(globals, given, {}, run);
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  const InterruptWatch watch;
  options.stop.interrupted = &watch.flag();
  options.stop.hurried = &watch.hurry();
  auto progress = std::make_unique<Progress>(globals, "session");
  TouchSessionResult result = run_touch_session(input, options, [&](const TouchProgress& p) {
    const std::string schedule =
        p.rehearsal > 0 ? fmt::format("schedule {} of {}  ", p.rehearsal, p.rehearsals) : std::string();
    progress->show(p.whole > 0 ? p.done / p.whole : 0,
                   schedule + (p.references ? fmt::format("references {:.0f} of {:.0f}", p.done, p.whole)
                                            : fmt::format("{:.1f} of {:.1f} s  {} states known", p.done,
                                                          p.whole, p.known)));
  });
  progress.reset();
  TouchSummary summary = summarise_touch(result, input, options);
  summary.field = {
      .sites = found.field->size(), .seconds = found.seconds, .patches = patches, .kept = found.kept};
  Json document = document_of(touch_summary_keys(), summary);
  document["provenance"] = provenance(scene.source.hash);
  write_touch_files(run, result, options.clock.kind == Clock::real);
  write_states_csv(run / "states.csv", result.states);
  write_whole(run / "summary.json", json_text(document, 2) + "\n");
  write_touch_report(run, result, input, options, summary, document, scene);
  if (globals.json)
    print_json(document);
  else
    tell_touch(globals, summary, run);
  if (result.interrupted)
    warn(globals,
         fmt::format("interrupted after {} frames: the files of the run hold what was done until then",
                     result.frames.size()));
  flush_warnings();
  return result.interrupted ? 1 : 0;
}

}  // namespace forefeel
