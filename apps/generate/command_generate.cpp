// forefeel generate SCENE -o S.states: fills the lattice outward from rest. Safe to kill; a rerun resumes.

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/document_keys.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/json.hpp"
#include "apps/console/look_at_it.hpp"
#include "apps/console/outputs.hpp"
#include "apps/console/provenance.hpp"
#include "apps/generate/generate_error.hpp"
#include "apps/generate/generate_memory.hpp"
#include "apps/generate/generate_sites.hpp"
#include "apps/generate/kept_states.hpp"
#include "apps/generate/site_ranks.hpp"
#include "apps/scene/mpi_run.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_field.hpp"
#include "geometry/common/counted.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/memory.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/coverage/design.hpp"
#include "geometry/index/lattice_room.hpp"
#include "geometry/states/energy_jet.hpp"
#include "geometry/states/state_file.hpp"
#include "geometry/states/state_outcome.hpp"
#include "scheduling/workers/generate_ranks.hpp"
#include "solver/equilibrium/solver.hpp"
#include "solver/lattice/generate.hpp"

namespace forefeel {
namespace {

struct GenerateArguments {
  std::string scene, output;
  std::optional<double> error;
  std::string where;  // of a scene with contact.anywhere
  MpiArguments mpi;
};

// Result of `forefeel generate` when it fills the lattice.
struct GenerateResult {
  GenerateReport report;                 // of this run
  std::size_t usable = 0, failed = 0;    // states in the file, including earlier runs
  std::size_t inverted = 0;              // of the usable
  bool interrupted = false;              // also by a file that could not be written
  std::optional<std::string> why = {};   // of the file
  bool shown = false;                    // the user knows that it was interrupted
  std::optional<FarmReport> ranks = {};  // with --mpi

  double states_per_second() const {
    return report.seconds > 0 ? static_cast<double>(report.solved) / report.seconds : 0.0;
  }
};

struct Generated {
  const GenerateResult& result;
  const Scene& scene;
};

std::optional<double> parallel_time(const Generated& generated, double ParallelTimes::*time) {
  if (generated.result.ranks) return {};
  return generated.result.report.parallel.*time;
}

const JsonKeys<Generated>& generate_keys() {
  using G = Generated;
  static const JsonKeys<G> keys{
      {"states", "", "usable states in the file", [](const G& g) { return g.result.usable; }},
      {"solved", "", "of this run",
       [](const G& g) { return g.result.report.solved - g.result.report.inverted; }},
      {"inverted", "", "states with inverted elements in the file",
       [](const G& g) { return g.result.inverted; }},
      {"failed", "", "solves that failed", [](const G& g) { return g.result.failed; }},
      {"resumed", "", "states that were in the file before",
       [](const G& g) { return g.result.report.resumed; }},
      {"seconds", "s", "time of the run", [](const G& g) { return g.result.report.seconds; }},
      {"states_per_second", "1/s", "solved in this run",
       [](const G& g) { return g.result.states_per_second(); }},
      {"threads", "", "that solved", [](const G& g) { return g.result.report.threads; }},
      {"parallel.work_s", "s", "processor time of all pieces of work; null with --mpi",
       [](const G& g) { return parallel_time(g, &ParallelTimes::work); }},
      {"parallel.path_s", "s",
       "the same of the longest chain of pieces that wait for each other: no number of threads is faster",
       [](const G& g) { return parallel_time(g, &ParallelTimes::path); }},
      {"parallel.idle_s", "s", "waiting of all threads for a piece, by the clock",
       [](const G& g) { return parallel_time(g, &ParallelTimes::idle); }},
      {"ranks.solving", "", "with --mpi: ranks that solved",
       [](const G& g) { return g.result.ranks ? std::optional(g.result.ranks->ranks) : std::nullopt; }},
      {"ranks.lost", "", "with --mpi: ranks that answered no more",
       [](const G& g) { return g.result.ranks ? std::optional(g.result.ranks->lost) : std::nullopt; }},
      {"error_estimate", "1", "null: only with --error", [](const G&) { return nullptr; }},
      {"interrupted", "", "true: some positions are left; the same command resumes",
       [](const G& g) { return g.result.interrupted; }},
      {"spacing", "m", "of the lattice", [](const G& g) { return g.scene.space.spacing; }},
      {"spacing_auto", "", "with spacing = auto: how it was chosen",
       [](const G& g) {
         return g.scene.spacing.chosen ? std::optional(to_json(*g.scene.spacing.chosen)) : std::nullopt;
       }},
      {"spacing_auto.KEY", "", "the same"}};
  return keys;
}

void tell(const Globals& globals, const GenerateResult& result, const std::string& output) {
  say(globals,
      fmt::format("{}: {}{}, {} solved in {:.2f} s ({:.0f} states/s, {}), {} there before, {} failed", output,
                  counted(result.usable, "state"), inverted_in_words(result.inverted),
                  result.report.solved - result.report.inverted, result.report.seconds,
                  result.states_per_second(),
                  counted(static_cast<std::size_t>(result.report.threads), result.ranks ? "rank" : "thread"),
                  result.report.resumed, result.failed));
}

StateFileHeader header_of(const Scene& scene) {
  StateFileHeader header;
  header.identity = scene.identity;
  header.spacing = scene.space.spacing;
  header.box = scene.space.box;
  header.notes["scene"] = scene.source.file.string();
  if (scene.spacing.chosen) header.notes["spacing"] = in_words(*scene.spacing.chosen);
  header.notes["provenance"] = json_text(provenance(scene.source.hash));
  return header;
}

LatticeOptions options_of(const Scene& scene) {
  LatticeOptions options;
  options.spacing = scene.space.spacing;
  options.box = scene.space.box;
  options.want_displacements = scene.kept.displacements;
  options.jet = scene.kept.jet;
  return options;
}

// Warnings about ranks are shown at once, because the user may have to act on a hanging rank.
FarmOptions farm_options(const Globals& globals, const std::stop_token& stop,
                         const std::function<void()>& tick) {
  return {.queue = 2, .stop = stop, .tick = tick, .note = [&globals](const std::string& line) {
            warn(globals, line);
            flush_warnings();
          }};
}

// When a rank has died, mpirun sends a signal to the others and ends them about a second later. So the warning is
// printed at once.
void tell_ended_ranks(KeptStates& kept, const std::string& output) {
  kept.flush();
  std::cerr << "forefeel: "
            << (kept.failed() ? kept.in_words()
                              : fmt::format("ended by a signal (mpirun sends one when a rank has died); {} "
                                            "states are kept in {}; rerun the same command to resume",
                                            kept.in_file(), output))
            << std::endl;
}

// ranks: null where threads solve. watch: created with the first state. Before that, while the lattice is planned, a
// signal ends the program; nothing is lost.
GenerateResult fill_lattice(const Globals& globals, const Scene& scene, StateFile file,
                            const std::vector<State>& known, const std::string& output, RankPool* ranks,
                            std::optional<InterruptWatch>& watch) {
  std::stop_source stop;
  LatticeOptions options = options_of(scene);
  options.threads = globals.threads;
  options.stop = stop.get_token();

  GenerateResult result;
  const auto raised = [&] { return watch && watch->raised(); };
  if (ranks) watch.emplace();
  KeptStates kept(std::move(file), known.size(), stop);
  Progress progress(globals, "generate");
  const auto start = std::chrono::steady_clock::now();
  std::size_t fresh = 0;
  const auto keep = [&](State state) {
    if (!watch) watch.emplace();
    ++fresh;
    kept.keep(std::move(state));
  };
  double shown = 0;  // [s]
  const auto show = [&](std::size_t done, std::size_t total) {
    if (raised()) stop.request_stop();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (done < total && seconds < shown + 0.02) return;  // threads wait for each other here
    shown = seconds;
    progress.show(static_cast<double>(done) / static_cast<double>(total),
                  fmt::format("{} of {} states ({} there before), {:.0f} states/s", done, total, known.size(),
                              seconds > 0 ? static_cast<double>(fresh) / seconds : 0.0));
  };
  const auto tick = [&] {
    if (!raised() || result.shown) return;
    stop.request_stop();
    result.shown = true;
    tell_ended_ranks(kept, output);
  };
  if (ranks && !is_linear(*scene.body)) {
    const RankedGenerateReport report = generate_with_ranks(*ranks, scene.body, options, known, keep, show,
                                                            farm_options(globals, options.stop, tick));
    result.report = report.states;
    result.ranks = report.farm;
  } else if (scene.space.design != Design::lattice) {
    const std::vector<Vec3> places = designed_places(scene.space);
    result.report = generate_places(scene.body, places, options, keep, show, known);
  } else {
    if (ranks) options.threads = 1;  // three solves give all states of a linear body
    result.report = generate_lattice(scene.body, options, keep, show, known);
    if (ranks) result.ranks = FarmReport{};
  }
  kept.flush();
  result.interrupted = raised() || kept.failed();
  if (kept.failed()) {
    result.why = kept.in_words();
    kept.correct(result.report.solved, result.report.failed, result.report.inverted);
  }
  const auto usable = static_cast<std::size_t>(std::ranges::count_if(known, &State::usable));
  result.usable = usable + result.report.solved;
  result.inverted =
      static_cast<std::size_t>(std::ranges::count_if(known, has_inverted_elements)) + result.report.inverted;
  result.failed = known.size() - usable + result.report.failed;
  return result;
}

bool by_error(const GenerateArguments& arguments, const Scene& scene) {
  return arguments.error || scene.space.design == Design::error;
}

// The scene, checked against the arguments before the file is touched.
Scene checked_scene(const Globals& globals, const GenerateArguments& arguments) {
  if (arguments.error && !(*arguments.error > 0 && std::isfinite(*arguments.error)))
    throw InputError("--error",
                     fmt::format("{} given, expected a relative error above 0, as 0.01", *arguments.error));
  check_appendable(arguments.output);
  Scene scene = load_scene_with_sites(arguments.scene, globals.set, {.quiet = globals.quiet});
  if (!is_anywhere(scene) && !arguments.where.empty())
    throw InputError("--where", "is a part of the surface, expected a scene with contact.anywhere = true");
  for (const std::string& warning : scene.source.warnings) warn(globals, warning);
  if (scene.spacing.chosen) say(globals, in_words(*scene.spacing.chosen));
  if (is_anywhere(scene)) return scene;
  if (arguments.error && scene.space.design != Design::lattice && scene.space.design != Design::error)
    throw InputError("--error",
                     fmt::format("places states by their error, expected state_space.design = \"error\", "
                                 "not \"{}\"",
                                 name(scene.space.design)));
  if (by_error(arguments, scene))
    check_generate_to_error(scene);
  else if (scene.space.design == Design::lattice &&
           !holds_lattice_position(scene.space.box, scene.space.spacing))
    throw InputError(
        scene.written.box_place,
        fmt::format("holds no position of the lattice of {:g} m, expected a box that holds one, or a smaller "
                    "state_space.spacing",
                    scene.space.spacing));
  else
    check_memory_of_lattice(scene, available_memory());
  check_memory_of_threads(scene, globals.threads, available_memory());
  return scene;
}

// A file that was moved lacks its newest states: they remain in FILE-wal under the old name.
bool is_gone(const Globals& globals, const std::string& output) {
  if (is_database(output)) return false;
  warn(globals, fmt::format("{}: was moved or removed while states were written, so it is incomplete; "
                            "generate them again",
                            output));
  return true;
}

int run_generate(const Globals& globals, const GenerateArguments& arguments, RankPool* ranks) {
  const Scene scene = checked_scene(globals, arguments);
  end_if_interrupted("anything was solved");
  if (is_anywhere(scene))
    return generate_sites(globals, scene, {arguments.output, arguments.where, arguments.error}, ranks);
  if (ranks && by_error(arguments, scene))
    throw InputError("--mpi",
                     "has no use with --error and with design = \"error\", where each state is placed by "
                     "those before it; expected one of the two");
  if (ranks && scene.space.design != Design::lattice)
    throw InputError("--mpi", "solves lattices, expected state_space.design = \"lattice\"");
  StateFile file = StateFile::open_or_create(arguments.output, header_of(scene));
  const bool held =
      !scene.spacing.chosen || scene.spacing.chosen->holds;  // otherwise the scene has a warning
  const std::vector<State> known = file.read_all();
  if (file.damaged() > 0) warn(globals, damage_in_words(arguments.output, file.damaged(), true));
  file.drop_damaged();
  if (by_error(arguments, scene)) {
    const int code = generate_to_error(globals, scene, std::move(file), arguments.output, arguments.error);
    if (is_gone(globals, arguments.output)) return 1;
    say(globals, look_at_it(globals, arguments.output, arguments.scene));
    return std::max(code, held ? 0 : 1);
  }

  if (ranks) ranks->begin(rank_identity(scene.source.hash), pack_spacing(scene.space.spacing));
  std::optional<InterruptWatch> watch;  // until the result is told
  const GenerateResult result =
      fill_lattice(globals, scene, std::move(file), known, arguments.output, ranks, watch);
  if (!result.interrupted && is_database(arguments.output))
    StateFile::open_or_create(arguments.output, header_of(scene)).order_outward();
  if (globals.json) print_json(document_of(generate_keys(), Generated{result, scene}));
  tell(globals, result, arguments.output);
  if (is_gone(globals, arguments.output)) return 1;
  say(globals, look_at_it(globals, arguments.output, arguments.scene));
  if (result.interrupted) {
    if (!result.shown || result.why)
      warn(globals, result.why.value_or("interrupted; rerun the same command to resume"));
    return 1;
  }
  if (result.inverted > 0)
    warn(globals, fmt::format("states with inverted elements: {}. No body takes such a shape; they do not "
                              "count as solved",
                              result.inverted));
  if (result.failed == 0) return held ? 0 : 1;
  warn(globals, fmt::format("{} did not converge; forefeel export names each and why",
                            counted(result.failed, "state")));
  return 1;
}

// Only rank 0 checks, so that there is a single error line.
void check_mpi(const Globals& globals) {
  if (globals.threads > 1)
    throw InputError("--threads",
                     fmt::format("is {}, but with --mpi each rank solves with one thread, expected more "
                                 "ranks instead",
                                 globals.threads));
}

int run_with_mpi(const Globals& globals, const GenerateArguments& arguments) {
  const auto lead = [&](RankPool& ranks) {
    check_mpi(globals);
    return run_generate(globals, arguments, &ranks);
  };
  const auto load = [&](const RankContext& rank) {
    const Scene scene = load_scene_with_sites(arguments.scene, globals.set, {.spacing = false});
    if (is_anywhere(scene))
      return LoadedWorker{.worker = make_site_worker(rest_sites_of(scene), received_spacing(scene, rank)),
                          .identity = rank_identity(scene.source.hash)};
    LatticeOptions options = options_of(scene);
    options.spacing = received_spacing(scene, rank);
    return LoadedWorker{.worker = make_lattice_worker(scene.body, options, rank.ended),
                        .identity = rank_identity(scene.source.hash)};
  };
  return run_ranked(globals, arguments.mpi, {.lead = lead, .load = load});
}

}  // namespace

DeclaredTable generate_output() {
  return {"generate.json", "Of generate --json.", declared(generate_keys())};
}

void add_generate(CommandLine& line) {
  const auto arguments = std::make_shared<GenerateArguments>();
  Command sub = line.add("generate", "Solve the lattice of a scene, outward from rest; a rerun resumes");
  sub.runs([arguments](const Globals& globals) {
    return arguments->mpi.on ? run_with_mpi(globals, *arguments) : run_generate(globals, *arguments, nullptr);
  });
  sub.option("SCENE", arguments->scene, "Scene (TOML)").required();
  sub.option("-o,--output", arguments->output, "State file; resumed if it exists")
      .required()
      .shows("S.states");
  sub.option("--error", arguments->error,
             "Instead of a lattice, solve as few states as keep this relative error:\n"
             "95 % of the box within E, all of it within 2 E")
      .shows("E");
  sub.option("--where", arguments->where,
             "With contact.anywhere: the part of the surface, a ball x/y/z/radius [m] or a node group. "
             "Default: all")
      .shows("PART");
  add_mpi_options(
      sub, arguments->mpi,
      "All ranks of mpirun -n N forefeel generate --mpi … solve; rank 0 writes. The states are the same");
}

}  // namespace forefeel
