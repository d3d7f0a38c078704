// forefeel session SCENE … -o RUN/: a headless haptic session. Options that are not given come from the
// scene.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <iterator>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/look_at_it.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/scene/given_states.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "apps/scene/scene_mesh_error.hpp"
#include "apps/session/away_from_states.hpp"
#include "apps/session/report.hpp"
#include "apps/session/session_arguments.hpp"
#include "apps/session/session_document.hpp"
#include "apps/session/session_folder.hpp"
#include "apps/session/session_screen.hpp"
#include "apps/session/session_shapes.hpp"
#include "apps/session/session_states.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/policy/policy.hpp"
#include "scheduling/record/attention.hpp"
#include "scheduling/record/notes.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/session/input_replay.hpp"
#include "scheduling/session/session_setup.hpp"
#include "scheduling/touch/surface_models.hpp"
#include "scheduling/workers/rank_workers.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

std::string text_for(const SessionProgress& p) {
  if (p.phase != SessionPhase::session || p.rehearsals > 0)
    return fmt::format("{} {:.0f} of {:.0f}", phase_in_words(p), p.t, p.seconds);
  return fmt::format("{:.1f} of {:.1f} s  {} states known, {} solved  {}", p.t, p.seconds, p.known, p.solved,
                     name(p.label));
}

// The slices and the state file are made on separate threads while the errors are computed.
struct Meanwhile {
  std::future<void> states;  // in their file
  Picture slices;

  // sliced: the labels are of places, not of sites.
  void begin(const SessionResult& result, const StateSpaceOptions& space, const fs::path& run, bool sliced) {
    if (sliced) slices = begin_slices(result, space);
    states = std::async(std::launch::async,
                        [all = result.states, file = run / "states.csv"] { write_states_csv(file, all); });
  }
};

// Writes one file after the other. If one file cannot be written, the others still are.
class WriteAttempts {
 public:
  explicit WriteAttempts(std::vector<std::string> failures) : failures_(std::move(failures)) {}
  template <class Write>
  void attempt(const std::string& what, Write write) {
    try {
      write();
    } catch (const std::bad_alloc&) {
      failures_.push_back(what + " is not written: out of memory");
    } catch (const std::exception& problem) {
      failures_.push_back(problem.what());
    }
  }
  const std::vector<std::string>& failures() const { return failures_; }  // one line each

 private:
  std::vector<std::string> failures_;
};

// 1 for a session that was interrupted or lost results; warnings say how far it came and what failed.
int exit_code(const Globals& globals, const SessionResult& result, const SessionPlan& plan,
              const std::vector<std::string>& failures) {
  for (const std::string& failure : failures) warn(globals, failure);
  if (!result.interrupted()) {
    flush_warnings();
    return failures.empty() ? 0 : 1;
  }
  if (result.run.end == RunEnd::not_begun)
    warn(globals, fmt::format("{}: 0 of {} frames; the files of the run hold what was known at the start",
                              result.notes.front(), plan.frames));
  else
    warn(globals, fmt::format("interrupted after {} of {}, {} solved: the files of the run "
                              "hold what was done until then",
                              result.frames.size(), counted(plan.frames, "frame"),
                              counted(result.counts.solved, "state")));
  flush_warnings();
  return 1;
}

// Waits until the other ranks have the scene.
void gather(const Globals& globals, RankPool& ranks, const Scene& scene) {
  constexpr double longest = 600;  // [s], of loading
  ranks.begin(rank_identity(scene.source.hash), pack_spacing(scene.space.spacing));
  ranks.wait_until_loaded(longest);
  const std::string why = ranks.notes().empty() ? "they still load the scene" : ranks.notes().back();
  if (ranks.taking_jobs() == 0) throw InputError("--mpi", "none of the other ranks can solve: " + why);
  if (ranks.taking_jobs() < ranks.ranks()) warn(globals, why);
}

// The plan with its ranks, the states known at the start, and the files of the run.
SessionPlan planned_run(const Globals& globals, const SessionArguments& given, const Scene& scene,
                        const std::shared_ptr<RankPool>& ranks, bool shapes,
                        std::optional<SessionField>& field) {
  SessionPlan plan = plan_of(globals, given, scene, ranks, shapes, field);
  if (ranks) gather(globals, *ranks, scene);
  end_if_interrupted("the session began");
  plan =
      take_states(scene, given.states, fs::path(given.output) / "session.states", globals, std::move(plan));
  plan = with_inputs_file(std::move(plan), fs::path(given.output) / inputs_file_name, program_text());
  keep_replayed(plan.options, given.output);
  return plan;
}

// The documents of a run: summary.json, report.html and the figures.
struct RunDocuments {
  const Globals& globals;
  const SessionArguments& given;
  const Scene& scene;
  const SessionResult& result;
  const StateSpaceOptions& space;
  RunView view;
  SessionSummary summary;
  std::optional<SessionField> field = {};
  nlohmann::ordered_json document = {};

  void begin(const SessionShapes& shapes) {
    document = session_document(summary, result, scene, field);
    shapes.add_to(document);
  }

  void write(const fs::path& run, const ReportPictures& pictures, WriteAttempts& files) {
    files.attempt("summary.json", [&] { write_whole(run / "summary.json", json_text(document, 2) + "\n"); });
    files.attempt("report.html", [&] { write_report(run, summary, document, scene, pictures); });
    if (!given.figures.formats.empty())
      files.attempt("figures", [&] {
        write_figures(globals, figures_in(run), given.figures.formats, run_figures(result, space, view));
      });
    document["failures"] = files.failures();
  }

  void show(const std::optional<std::string>& shapes, const fs::path& run) const {
    if (globals.json) return print_json(document);
    tell_session(globals, summary, shapes, run);
    if (const std::optional<Tolerance>& tolerance = scene.written.tolerance)
      say(globals, tolerance_in_words(tolerance_share(result, *tolerance), *tolerance));
  }
};

// 1 also for an unstable session.
int ended(const Globals& globals, const SessionSummary& summary, int code) {
  if (!summary.energy.stability || summary.energy.stability->stable) return code;
  if (globals.json || globals.quiet) warn(globals, attention(summary).front());
  flush_warnings();
  return 1;
}

int run_session_command(const Globals& globals, const SessionArguments& given,
                        const std::shared_ptr<RankPool>& ranks) {
  take_figures(given.figures);
  const Scene scene = load_scene_with_sites(given.scene, globals.set, {.quiet = globals.quiet});
  const ShapeOptions shape = shape_options(scene, given);
  std::optional<SessionField> field;
  SessionPlan plan = planned_run(globals, given, scene, ranks, shape.rate > 0, field);
  const SessionOptions& options = plan.options;
  const StateSpaceOptions& space = plan.input.touched.space;
  const fs::path run = given.output;
  SessionShapes shapes(shape, plan, given);
  const FolderLock lock = claim_run_folder(globals, given, shapes.files(), run);
  warn_of_replay(globals, scene, given);
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  if (scene.spacing.chosen) say(globals, in_words(*scene.spacing.chosen));

  std::unique_ptr<Progress> progress = std::make_unique<Progress>(globals, "session");
  const InterruptWatch watch;  // also while the files are written
  plan.options.stop.interrupted = &watch.flag();
  plan.options.stop.hurried = &watch.hurry();
  Meanwhile meanwhile;
  const bool beside = options.clock.kind == Clock::real && !plan.input.foreign && !field;
  MeshErrorTask mesh(scene, beside ? MeshErrorTask::When::meanwhile : MeshErrorTask::When::at_the_end);
  PredictorScores predictions(options.clock.frame, options.motion.predictor,
                              factory_context(plan.input, options.seed));
  SessionResult result = run_session(
      plan,
      {.progress =
           [&](const SessionProgress& p) {
             progress->show(p.seconds > 0 ? p.t / p.seconds : 0, text_for(p));
           },
       .when_run = [&](const SessionResult& so_far) { meanwhile.begin(so_far, space, run, !field); },
       .each_position = [&](const Vec3& at) { predictions.add(at); }},
      shapes.wanted());
  progress.reset();
  for (const std::string& warning : result.warnings) warn(globals, warning);
  WriteAttempts files(result.failures);
  progress = std::make_unique<Progress>(globals, "session");
  progress->show("writing the tables");
  const auto write_tables = [&] {
    files.attempt("the run's tables", [&] { write_run_files(run, result, options); });
  };
  const SessionSummary::AwayFromStates away =
      away_from_states(result, plan, write_tables, stages_of(*progress, "error of the states given"));
  progress = std::make_unique<Progress>(globals, "session: report and files");

  shapes.begin_files(run);
  const RunView view = view_of(space, options, plan.render.safety.force_limit);
  ReportPictures pictures = begin_pictures(result, meanwhile.slices, view);
  pictures.shape = shapes.begin_picture();
  if (field) pictures.sites = begin_sites(result, plan.input.touched.anywhere->field->rest());
  files.attempt("states.csv", [&] { meanwhile.states.get(); });
  files.attempt("the shapes", [&] { shapes.finish_files(run); });
  const MeshError by_mesh = plan.input.foreign ? MeshError{} : mesh.get();
  RunDocuments documents{
      globals, given, scene, result, space, view, whole_summary(result, plan, predictions, away, by_mesh),
      field};
  documents.summary.run.failures = files.failures();
  documents.begin(shapes);
  documents.write(run, pictures, files);
  progress.reset();
  documents.show(shapes.in_words(), run);
  return ended(globals, documents.summary, exit_code(globals, result, plan, files.failures()));
}

int run_with_mpi(const Globals& globals, const SessionArguments& given) {
  const auto lead = [&](RankPool& pool) {
    if (pool.ranks() < 1)
      throw InputError(
          "--mpi", "there is one rank, expected more: mpirun -n 3 forefeel session --mpi … has two workers");
    const std::shared_ptr<RankPool> shared(&pool, [](RankPool*) {});
    return run_session_command(globals, given, shared);
  };
  const auto load = [&](const RankContext& rank) {
    const Scene scene = load_scene_with_sites(given.scene, globals.set, {.spacing = false});
    const StateSolverOptions solving{
        .spacing = received_spacing(scene, rank),
        .tolerance = 1e-6,
        .displacements = scene.kept.displacements || shape_options(scene, given).rate > 0,
        .jet = scene.kept.jet,
        .sites = is_anywhere(scene) ? rest_sites_of(scene) : nullptr};
    return LoadedWorker{.worker = make_state_worker(scene.body, solving),
                        .identity = rank_identity(scene.source.hash)};
  };
  return run_ranked(globals, given.mpi, {.lead = lead, .load = load, .load_at_once = true});
}

}  // namespace

void add_session(CommandLine& line) {
  const auto given = std::make_shared<SessionArguments>();
  Command sub =
      line.add("session", "A haptic session with a simulated hand: workers solve while a 1 kHz loop renders");
  sub.runs([given](const Globals& globals) {
    return given->mpi.on ? run_with_mpi(globals, *given) : run_session_command(globals, *given, nullptr);
  });
  sub.option("SCENE", given->scene, "Scene (TOML); its [session] holds the defaults").required();
  sub.option(
         "--states", given->states.file,
         "States known at the start (.states or CSV), of this body. The file is not changed: new states are "
         "written to RUN/session.states")
      .shows("S");
  const Option extend = sub.flag("--extend", given->states.extend,
                                 "Append new states to the file of --states; it is made if missing");
  sub.flag("--foreign", given->states.foreign, foreign_help).excludes(extend);
  sub.option("--device", given->motion.device,
             "The hand: path:NAME[,speed=…,amplitude=…,tremor=…,noise=…], "
             "trace:FILE[,columns=…,rate=…,unit=…,tool=…,"
             "scale=…,offset=x/y/z] or hand:PROFILE[,target=NAME,grip=…]");
  sub.option("--clock", given->motion.clock, "real or virtual");
  sub.option("--seconds", given->motion.seconds, "Length [s]");
  sub.option("--workers", given->solving.workers, "Workers that solve");
  sub.option("--workers-kind", given->solving.workers_kind, "threads, or a kind that this program registers");
  add_figures(sub, given->figures, "RUN/figures");
  add_mpi_options(sub, given->mpi,
                  "Real clock: the workers are the other ranks of mpirun -n N forefeel session --mpi …");
  sub.option(
      "--policy", given->solving.policy,
      "What is solved next: " + listed(policy_names()) +
          ". clairvoyant is an upper bound: it simulates all ten schedules, then runs the best; it takes "
          "about eleven times as long");
  sub.option("--predictor", given->motion.predictor, "Where the hand will be: " + listed(predictor_names()));
  sub.option(
      "--shape-rate", given->shape_rate,
      "Shapes of the body per second, in RUN/shape.pvd and for forefeel show; 0: none. The points are moved "
      "already: in ParaView, Warp By Vector of displacement by -1 shows the body at rest, by k - 1 the "
      "motion k times as large");
  sub.option("--switch", given->switching,
             "How the force changes from one model to the next: paper, smooth or none");
  sub.option("--cost", given->solving.cost,
             "Virtual clock: time of a solve [s], constant:S, lognormal:MEDIAN,SIGMA, recorded or paper");
  sub.option("--latency", given->solving.latency, "Virtual clock: time of a message to or from a worker [s]");
  sub.option("--select", given->select,
             "Which states a model uses: nearest, or label (outside safe regions from all sides of the HIP)");
  const Option arrivals = sub.option("--arrivals", given->solving.arrivals,
                                     "CSV t,x,y,z, rows in any order: states become known at given times");
  sub.option("--replay", given->motion.replay, "A run folder: motion and arrivals as recorded there")
      .excludes(arrivals);
  sub.option(
         "-o,--output", given->output,
         "Folder for the files of the run. In its report and columns, rendered is the force before the "
         "safety rules (rendered_x …), sent the force after them (fx, fy, fz); errors are those of rendered")
      .shows("RUN/")
      .required();
}

}  // namespace forefeel
