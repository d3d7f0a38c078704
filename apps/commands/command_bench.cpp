// forefeel bench approx|solver|coverage|switch [SCENE]: speed against error, ratios to named baselines of the
// same run.

#include <fmt/format.h>

#include <memory>

#include "apps/bench/bench_elements.hpp"
#include "apps/bench/bench_hard_cases.hpp"
#include "apps/console/command.hpp"
#include "apps/scene_input/scene.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

struct BenchOptions {
  std::string what;
  std::string scene;
  std::string output;
  std::size_t states = 0;
};

int run_bench(const Globals& globals, const BenchOptions& options) {
  if (!options.output.empty() && options.what != "approx" &&
      !(options.what == "solver" && options.scene == "hard-cases"))
    throw InputError("--output",
                     "only bench approx and bench solver hard-cases write files, expected none here");
  if (options.states > 0 &&
      (options.what != "solver" || options.scene == "hard-cases" || options.scene == "elements"))
    throw InputError("--states", "only bench solver of a scene takes it, expected none here");
  const bool own_bodies =
      options.what == "solver" && (options.scene == "hard-cases" || options.scene == "elements");
  if (!globals.set.empty() && (own_bodies || (options.what == "coverage" && options.scene.empty())))
    throw InputError("--set",
                     fmt::format("{}, without effect on bench {}{}, which reads no scene, expected none here",
                                 globals.set.front(), options.what, own_bodies ? " " + options.scene : ""));
  if (options.what == "coverage") {
    if (!options.scene.empty()) {
      load_scene(options.scene, globals.set);
      warn(globals, "bench coverage draws its own states; of the scene it only checks that it is one");
    }
    return bench_coverage(globals);
  }
  if (options.what == "solver" && options.scene == "hard-cases")
    return bench_hard_cases(globals, options.output);
  if (options.what == "solver" && options.scene == "elements") return bench_elements(globals);
  if (options.what == "solver") return bench_solver(globals, options.scene, options.states);
  if (options.what == "approx") return bench_approx(globals, options.scene, options.output);
  return bench_switch(globals, options.scene);
}

}  // namespace

void add_bench(CLI::App& app, Commands& commands) {
  const auto options = std::make_shared<BenchOptions>();
  CLI::App& sub =
      add_command(app, commands, "bench", "Speed against error, beside named baselines of the same run",
                  [&commands, options] { return run_bench(commands.globals, *options); });
  sub.add_option("WHAT", options->what, "approx, solver, coverage or switch")
      ->required()
      ->check(CLI::IsMember({"approx", "solver", "coverage", "switch"}));
  sub.add_option("SCENE", options->scene,
                 "Scene to take states from; default: the built-in one of each bench.\n"
                 "For solver also: hard-cases (a table of difficult bodies), elements (locking)");
  sub.add_option("-o,--output", options->output,
                 "Folder: approx.csv and .svg of approx, hard_cases.csv and .html of hard-cases")
      ->type_name("DIR");
  sub.add_option(
         "--states", options->states,
         "bench solver: the lattice of a box shrunk about rest to at most N states, for large bodies;\n"
         "1: a single state, its time and memory")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1000000}));
}

}  // namespace forefeel
