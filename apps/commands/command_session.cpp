// forefeel session SCENE … -o RUN/: a headless haptic session. Options that are not given come from the scene.

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/commands/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/summary_json.hpp"
#include "apps/picture/report.hpp"
#include "apps/scene_input/scene_session.hpp"
#include "apps/scene_input/spec_text.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/states/state_file.hpp"
#include "scheduling/motion/prediction_score.hpp"
#include "scheduling/motion/predictor.hpp"
#include "scheduling/record/run_files.hpp"
#include "scheduling/workers/mpi_workers.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

struct SessionArguments {
  std::string scene, states, output;
  std::optional<std::string> device, clock, policy, switching, cost, arrivals, replay, select, predictor,
      workers_kind;
  std::optional<double> seconds, latency;
  std::optional<int> workers;
  bool mpi = false;
};

template <class T>
T one_of(const std::string& given, const char* option, std::initializer_list<T> values) {
  std::string names;
  for (const T value : values) {
    if (given == name(value)) return value;
    names += (names.empty() ? "" : ", ") + std::string(name(value));
  }
  throw InputError(option, fmt::format("is '{}', expected {}", given, names));
}

SessionOptions options_of(const Scene& scene, const SessionArguments& given, const Globals& globals) {
  SessionOptions options = scene.session;
  options.model.fit = scene.model;
  if (given.clock) {
    if (*given.clock != "real" && *given.clock != "virtual")
      throw InputError("--clock", fmt::format("is '{}', expected real or virtual", *given.clock));
    options.clock.kind = *given.clock == "real" ? Clock::real : Clock::virtual_time;
  }
  if (!given.replay)
    options.motion.device = given.device ? device_from_text(*given.device) : device_of(scene);
  options.workers.cost = given.cost ? cost_from_text(*given.cost) : cost_of(scene);
  if (given.policy) options.planning.policy = part_from_text("policy", *given.policy);
  if (given.predictor) options.motion.predictor = part_from_text("predictor", *given.predictor);
  if (given.workers_kind) options.workers.kind = part_from_text("workers", *given.workers_kind);
  options.clock.seconds = given.seconds.value_or(options.clock.seconds);
  // A motion that ends is run to its end if it was asked for on the command line. One from the scene runs no
  // longer than the scene says.
  if (!given.seconds)
    options.clock.length = given.device || given.replay ? RunLength::motion : RunLength::shorter;
  options.workers.latency = given.latency.value_or(options.workers.latency);
  options.workers.count = given.workers.value_or(options.workers.count);
  if (given.arrivals) options.planning.arrivals = *given.arrivals;
  if (given.replay) options.motion.replay = *given.replay;
  if (given.switching)
    options.switching.rule =
        one_of(*given.switching, "--switch", {SwitchRule::paper, SwitchRule::smooth, SwitchRule::none});
  if (given.select)
    options.model.fit.select = one_of(*given.select, "--select", {Select::label, Select::nearest});
  options.workers.threads = globals.threads;
  if (globals.seed != 0) options.seed = globals.seed;
  return options;
}

// The plan with the states known at the start, and the file that new ones are appended to.
SessionPlan take_states(const Scene& scene, const SessionArguments& given, const Globals& globals,
                        SessionPlan plan) {
  if (given.states.empty())
    return with_state_file(std::move(plan), fs::path(given.output) / "session.states");
  const fs::path file = given.states;
  if (file.extension() == ".csv")  // measured or foreign states stay as they are
    return with_known(with_state_file(std::move(plan), fs::path(given.output) / "session.states"),
                      read_states_csv(file));
  plan = with_state_file(std::move(plan), file);
  if (!fs::exists(file)) {
    check_writable(file);
    warn(globals, fmt::format("{}: no such file yet; it is made, and the session starts with no known states",
                              file.string()));
    return plan;
  }
  StateFileHeader header{
      .identity = scene.identity, .spacing = scene.space.spacing, .box = scene.space.box, .notes = {}};
  StateFile states = StateFile::open_or_create(file, header);
  plan = with_known(std::move(plan), states.read_all());
  if (states.damaged() > 0) warn(globals, damage_in_words(file.string(), states.damaged(), true));
  states.drop_damaged();
  return plan;
}

// Options that choose what is solved, by which workers and when.
std::vector<std::string> scheduling_options(const SessionArguments& given) {
  std::vector<std::string> options;
  if (given.policy) options.push_back("--policy");
  if (given.predictor) options.push_back("--predictor");
  if (given.workers) options.push_back("--workers");
  if (given.workers_kind) options.push_back("--workers-kind");
  if (given.cost) options.push_back("--cost");
  if (given.latency) options.push_back("--latency");
  return options;
}

// A replay takes its motion and its arrivals from the run. Options of motion and planning are ignored; a
// warning says which.
void warn_of_replay(const Globals& globals, const Scene& scene, const SessionArguments& given) {
  if (!given.replay) return;
  std::vector<std::string> vain = scheduling_options(given);
  if (given.device) vain.insert(vain.begin(), "--device");
  for (const auto& [key, place] : scene.scheduling)
    if (!place.option.empty()) vain.push_back(place.text());
  if (!vain.empty()) warn(globals, fmt::format("{}: without effect with --replay", fmt::join(vain, ", ")));
}

// Nothing is solved where states arrive at given times. Options of solving are ignored; a warning says which.
void warn_of_solving(const Globals& globals, const Scene& scene, const SessionArguments& given) {
  if (given.replay || (!given.arrivals && scene.arrivals_place.empty())) return;
  const std::string arrivals = given.arrivals ? "--arrivals" : scene.arrivals_place.text();
  std::vector<std::string> options = scheduling_options(given);
  if (given.mpi) options.push_back("--mpi");
  for (const auto& [key, place] : scene.scheduling) options.push_back(place.text());
  if (!options.empty())
    warn(globals, fmt::format("{}: without effect where states arrive at given times ({})",
                              fmt::join(options, ", "), arrivals));
}

// The run that is replayed must not be overwritten.
void keep_replayed(const SessionOptions& options, const fs::path& run) {
  std::error_code error;
  if (options.motion.replay && fs::equivalent(*options.motion.replay, run, error))
    throw InputError("-o " + run.string(), "is the run that is replayed, expected another folder");
}

// States of an earlier run into this folder are renamed to session-1.states, session-2.states, … and kept.
void set_aside_states_of_last_run(const Globals& globals, const SessionInput& input, const fs::path& run) {
  const fs::path file = run / "session.states";
  if (input.files.states != file || !fs::exists(file)) return;
  int k = 1;
  while (fs::exists(run / fmt::format("session-{}.states", k))) ++k;
  warn(globals,
       fmt::format("{}: states of an earlier run, kept as session-{}.states; --states continues from them",
                   file.string(), k));
  for (const char* end : {"-wal", "-shm", ""}) {
    const fs::path part = file.string() + end;
    if (fs::exists(part)) fs::rename(part, run / fmt::format("session-{}.states{}", k, end));
  }
}

std::string text_for(const SessionProgress& p) {
  if (p.phase != SessionPhase::session || p.rehearsals > 0)
    return fmt::format("{} {:.0f} of {:.0f}", phase_in_words(p), p.t, p.seconds);
  return fmt::format("{:.1f} of {:.1f} s  {} states known, {} solved  {}", p.t, p.seconds, p.known, p.solved,
                     name(p.label));
}

// The error that each predictor would have made on this motion, by horizon; summed up while the session runs.
class PredictionScores {
 public:
  explicit PredictionScores(double frame) {
    constexpr double horizons[] = {0.02, 0.05, 0.1, 0.2, 0.5};  // [s]
    for (const std::string& name : predictor_names()) {
      predictors_.push_back(make_predictor(name));
      scores_.emplace_back(*predictors_.back(), frame, horizons);
    }
  }
  void add(const Vec3& at) {
    for (PredictionScore& score : scores_) score.add(at);
  }
  nlohmann::ordered_json json() const {
    nlohmann::ordered_json document = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < scores_.size(); ++i) {
      auto& rows = document[predictor_names()[i]] = nlohmann::ordered_json::array();
      for (const PredictionError& e : scores_[i].report())
        rows.push_back({{"horizon", e.horizon},
                        {"p50", number(e.p95 > 0 ? e.p50 : unknown)},
                        {"p95", number(e.p95 > 0 ? e.p95 : unknown)},
                        {"within_two_deviations", number(e.within_deviation)}});
    }
    return document;
  }

 private:
  std::vector<std::unique_ptr<Predictor>> predictors_;
  std::vector<PredictionScore> scores_;
};

std::string share(double value) {
  return std::isfinite(value) ? fmt::format("{:.1f} %", 100 * value) : "unknown";
}

void tell(const Globals& globals, const SessionSummary& s, const fs::path& run) {
  say(globals,
      fmt::format(
          "{} frames ({} clock), {} missed deadlines; {} states known at the start, {} solved, {} used",
          s.run.frames, s.settings.clock == Clock::real ? "real" : "virtual", s.deadline.missed,
          s.states.start, s.states.solved, s.states.used));
  say(globals, fmt::format("time in safe {}, sparse {}, gap {}, blank {}", share(s.time_in[Label::safe]),
                           share(s.time_in[Label::sparse]), share(s.time_in[Label::gap]),
                           share(s.time_in[Label::blank])));
  const SessionSummary::Errors& error = s.error.samples;
  say(globals,
      fmt::format("{} model switches, {} frames over the JND bound; error p50 {}, p95 {}, within JND {}",
                  s.switching.count, s.switching.frames_over_jnd, share(error.p50), share(error.p95),
                  share(error.within_jnd)));
  for (const std::string& note : s.run.notes) say(globals, note);
  say(globals, fmt::format("report: {}", (run / "report.html").string()));
}

// The slices and the states' file are made on threads of their own while the errors are computed.
struct Meanwhile {
  std::future<void> states;  // in their file
  Picture slices;

  void begin(const SessionResult& result, const StateSpaceOptions& space, const fs::path& run) {
    slices = begin_slices(result, space);
    states = std::async(std::launch::async,
                        [all = result.states, file = run / "states.csv"] { write_states_csv(file, all); });
  }
};

void join(const std::shared_ptr<MpiGroup>& mpi, const SessionArguments& given, SessionOptions& options) {
  if (options.clock.kind != Clock::real)
    throw InputError(
        "--mpi", "has no use under the virtual clock, whose workers are simulated; expected --clock real");
  if (mpi->ranks() < 2)
    throw InputError(
        "--mpi", "there is one rank, expected more: mpirun -n 3 forefeel session --mpi … has two workers");
  if (given.workers && *given.workers != mpi->ranks() - 1)
    throw InputError("--workers", fmt::format("is {}, but with --mpi the workers are the {} other ranks",
                                              *given.workers, mpi->ranks() - 1));
  options.workers.count = mpi->ranks() - 1;
  options.workers.mpi = mpi;
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
    const std::pair<const char*, bool> options[] = {{"seconds", given.seconds.has_value()},
                                                    {"workers", given.workers.has_value()},
                                                    {"policy", given.policy.has_value()},
                                                    {"latency", given.latency.has_value()},
                                                    {"predictor", given.predictor.has_value()}};
    for (const auto& [name, here] : options)
      if (here && key == std::string("session.") + name) return {"--" + option, problem};
    for (const std::string& set : globals.set)
      if (set.starts_with(key + "=")) return {InputPlace{.option = "--set", .key = key}, problem};
    return {InputPlace{.file = scene.file.string(), .key = key}, problem};
  }
  if (const InputPlace place = of("state_space.box", false, scene.box_place); !place.empty())
    return {place, problem};
  InputPlace place = of("device", given.device.has_value(), scene.device_place);
  if (place.empty()) place = of("cost", given.cost.has_value(), scene.cost_place);
  if (place.empty()) return error;
  const std::optional<std::string>& spec = error.place().value;  // "path:press,speed=x"
  return {place, spec ? fmt::format("'{}' {}", *spec, problem) : problem};
}

// The options and what they are for, checked; an error names the place that gave the value.
SessionPlan planned(const Globals& globals, const SessionArguments& given, const Scene& scene,
                    const std::shared_ptr<MpiGroup>& mpi) {
  try {
    SessionOptions options = options_of(scene, given, globals);
    warn_of_solving(globals, scene, given);
    if (mpi) join(mpi, given, options);
    return make_plan(session_input(scene), std::move(options));
  } catch (const InputError& error) {
    throw at_its_place(error, scene, given, globals);
  }
}

int run_session_command(const Globals& globals, const SessionArguments& given,
                        const std::shared_ptr<MpiGroup>& mpi) {
  const Scene scene = load_scene(given.scene, globals.set);
  SessionPlan plan = planned(globals, given, scene, mpi);
  if (mpi && mpi->rank() > 0) {
    mpi->serve(scene.body,
               {.spacing = scene.space.spacing, .tolerance = 1e-6, .displacements = scene.displacements});
    return 0;
  }
  const fs::path run = given.output;
  end_if_interrupted("the session began");
  plan = take_states(scene, given, globals, std::move(plan));
  const SessionOptions& options = plan.options;
  const SessionInput& input = plan.input;
  keep_replayed(options, run);
  prepare_run_folder(run);
  set_aside_states_of_last_run(globals, input, run);
  warn_of_replay(globals, scene, given);
  for (const std::string& warning : scene.warnings) warn(globals, warning);
  if (scene.chosen_spacing) say(globals, in_words(*scene.chosen_spacing));

  std::unique_ptr<Progress> progress = std::make_unique<Progress>(globals, "session");
  const InterruptWatch watch;  // also while the files are written
  plan.options.stop.interrupted = &watch.flag();
  plan.options.stop.hurried = &watch.hurry();
  Meanwhile meanwhile;
  PredictionScores predictions(options.clock.frame);
  const SessionResult result = run_session(
      plan, {.progress =
                 [&](const SessionProgress& p) {
                   progress->show(p.seconds > 0 ? p.t / p.seconds : 0, text_for(p));
                 },
             .when_run = [&](const SessionResult& so_far) { meanwhile.begin(so_far, scene.space, run); },
             .each_position = [&](const Vec3& at) { predictions.add(at); }});
  progress.reset();
  for (const std::string& warning : result.warnings) warn(globals, warning);

  const ReportPictures pictures = begin_pictures(result, meanwhile.slices);
  write_run_files(run, result, options);
  meanwhile.states.get();
  const SessionSummary summary = summarise(result, input, options);
  nlohmann::ordered_json document = to_json(summary);
  document["interrupted"] = result.interrupted();
  document["frames_asked"] = plan.frames;
  document["spacing"] = scene.space.spacing;
  if (scene.chosen_spacing) document["spacing_auto"] = to_json(*scene.chosen_spacing);
  document["prediction"] = predictions.json();  // [s], [m]
  document["provenance"] = provenance(scene.hash);
  OutputFile file(run / "summary.json");
  file.write(document.dump(2) + "\n");
  file.commit();
  write_report(run, summary, document, scene, pictures);
  if (globals.json) print_json(document);
  if (!globals.json) tell(globals, summary, run);
  if (!result.interrupted()) return 0;
  if (result.end == RunEnd::not_begun)
    warn(globals, fmt::format("{}: 0 of {} frames; the files of the run hold what was known at the start",
                              result.notes.front(), plan.frames));
  else
    warn(globals, fmt::format("interrupted after {} of {} frames, {} states solved: the files of the run "
                              "hold what was done until then",
                              result.frames.size(), plan.frames, result.counts.solved));
  flush_warnings();
  return 1;
}

// All ranks read the same input, so bad input ends all of them. Rank 0 reports it.
int run_with_mpi(const Globals& globals, const SessionArguments& given) {
  if (!MpiGroup::built())
    throw InputError("--mpi", "this build has no MPI, expected one made after `bash apps/setup.sh mpi`");
  const auto mpi = std::make_shared<MpiGroup>();
  if (mpi->rank() == 0) return run_session_command(globals, given, mpi);
  try {
    return run_session_command(globals, given, mpi);
  } catch (const std::exception& error) {
    if (mpi->told_to_stop(10)) return 0;  // rank 0 says why and ends with 2; mpirun would kill it before
    fmt::print(stderr, "forefeel: rank {}: {}\n", mpi->rank(), error.what());
    mpi->abort(2);
  }
}

}  // namespace

void add_session(CommandLine& line) {
  const auto given = std::make_shared<SessionArguments>();
  Command sub = line.add("session", "A headless haptic session: workers solve while a 1 kHz loop renders");
  sub.runs([given](const Globals& globals) {
    return given->mpi ? run_with_mpi(globals, *given) : run_session_command(globals, *given, nullptr);
  });
  sub.option("SCENE", given->scene, "Scene (TOML); its [session] holds the defaults").required();
  sub.option("--states", given->states, "States known at the start; new ones are appended (.states)")
      .shows("S");
  sub.option("--device", given->device,
             "path:NAME[,speed=…,amplitude=…,tremor=…,noise=…] trace:FILE[,scale=…,offset=x/y/z] or "
             "hand:PROFILE[,target=NAME,grip=…]");
  sub.option("--clock", given->clock, "real or virtual");
  sub.option("--seconds", given->seconds, "Length [s]");
  sub.option("--workers", given->workers, "Workers that solve");
  sub.option("--workers-kind", given->workers_kind, "threads, or a kind that this program registers");
  sub.flag("--mpi", given->mpi,
           "Real clock: the workers are the other ranks of mpirun -n N forefeel session --mpi …");
  sub.option("--policy", given->policy,
             "Rule that chooses what is solved next. clairvoyant is an upper bound: it simulates all seven "
             "schedules, then runs the best; it takes about seven times as long");
  sub.option("--predictor", given->predictor, "kalman or constant-velocity");
  sub.option("--switch", given->switching, "paper, smooth or none");
  sub.option("--cost", given->cost, "Virtual clock: constant:S, lognormal:MEDIAN,SIGMA, recorded or paper");
  sub.option("--latency", given->latency, "Virtual clock: time of a message to or from a worker [s]");
  sub.option("--select", given->select, "Neighbour set: label or nearest");
  const Option arrivals = sub.option("--arrivals", given->arrivals,
                                     "CSV t,x,y,z, rows in any order: states become known at given times");
  sub.option("--replay", given->replay, "A run folder: motion and arrivals as recorded there")
      .excludes(arrivals);
  sub.option("-o,--output", given->output, "Folder for the files of the run").shows("RUN/").required();
}

}  // namespace forefeel
