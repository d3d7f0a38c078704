// forefeel bench approx|solver|coverage|switch [SCENE]: speed, error, and ratios to named baselines measured
// in the same run.

#include <fmt/format.h>

#include <memory>

#include "apps/bench/bench.hpp"
#include "apps/bench/bench_elements.hpp"
#include "apps/bench/bench_hard_cases.hpp"
#include "apps/commands/commands.hpp"
#include "apps/console/console.hpp"
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
      load_scene(options.scene, globals.set, nullptr, {.spacing = false});
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

void add_bench(CommandLine& line) {
  const auto options = std::make_shared<BenchOptions>();
  Command sub = line.add("bench", "Measure speed and error beside named baselines in the same run");
  sub.runs([options](const Globals& globals) { return run_bench(globals, *options); });
  sub.option("WHAT", options->what, "approx, solver, coverage or switch")
      .required()
      .one_of({"approx", "solver", "coverage", "switch"});
  sub.option("SCENE", options->scene,
             "Scene to take states from; default: the built-in one of each bench.\n"
             "For solver also: hard-cases (a table of difficult bodies), elements (locking)");
  sub.option("-o,--output", options->output,
             "Folder: approx.csv and .svg of approx, hard_cases.csv and .html of hard-cases")
      .shows("DIR");
  sub.option("--states", options->states,
             "bench solver, for large bodies: shrink the box towards rest until its lattice has at most\n"
             "N states; 1: a single state, its time and memory")
      .shows("N")
      .between(std::size_t{1}, std::size_t{1000000});
}

}  // namespace forefeel
