// forefeel bench approx|solver|coverage|switch|loop|jet|truth [SCENE]: speed, error, and ratios to named baselines
// measured in the same run.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "apps/bench/bench.hpp"
#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/scene/scene.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

struct BenchOptions {
  std::string what;
  std::string scene;
  std::string output;
  std::size_t states = 0;
  std::optional<double> seconds;
  std::optional<int> blocks;
};

int run_bench(const Globals& globals, const BenchOptions& options) {
  if (!options.output.empty() && options.what != "approx" && options.what != "truth")
    throw InputError("--output", "only bench approx and bench truth write files, expected none here");
  if (options.what != "loop" && (options.seconds || options.blocks))
    throw InputError(options.seconds ? "--seconds" : "--blocks",
                     "only bench loop takes it, expected none here");
  if (options.states > 0 && options.what != "loop" && options.what != "solver")
    throw InputError("--states", "only bench loop and bench solver take it, expected none here");
  if (!globals.set.empty() && options.what == "coverage" && options.scene.empty())
    throw InputError(
        "--set", fmt::format("{}, without effect on bench coverage, which reads no scene, expected none here",
                             globals.set.front()));
  if (options.what == "coverage") {
    if (!options.scene.empty()) {
      load_scene(options.scene, globals.set, nullptr, {.spacing = false});
      warn(globals, "bench coverage draws its own states; of the scene it only checks that it is one");
    }
    return bench_coverage(globals);
  }
  if (options.what == "solver") return bench_solver(globals, options.scene, options.states);
  if (options.what == "approx") return bench_approx(globals, options.scene, options.output);
  if (options.what == "loop") {
    const LoopBench usual;
    return bench_loop(globals, options.scene,
                      {.seconds = options.seconds.value_or(usual.seconds),
                       .blocks = options.blocks.value_or(usual.blocks),
                       .states = options.states});
  }
  if (options.what == "jet") return bench_jet(globals, options.scene);
  if (options.what == "truth") return bench_truth(globals, options.scene, options.output);
  return bench_switch(globals, options.scene);
}

}  // namespace

std::vector<DeclaredTable> declared_bench_json() {
  return {declared_bench_approx(), declared_bench_solver(), declared_bench_coverage(),
          declared_bench_switch(), declared_bench_loop(),   declared_bench_jet(),
          declared_bench_truth()};
}

void add_bench(CommandLine& line) {
  const auto options = std::make_shared<BenchOptions>();
  Command sub = line.add("bench", "Measure speed and error beside named baselines in the same run");
  sub.runs([options](const Globals& globals) { return run_bench(globals, *options); });
  sub.option(
         "WHAT", options->what,
         "approx, solver, coverage, switch,\n"
         "jet: the energy jet at rest alone, its errors and its cost,\n"
         "truth: the whole error of a force, mesh and contact included, against what a state costs,\n"
         "loop: the 1 kHz loop of a session beside a bare loop that only waits for its deadlines, at the\n"
         "same time and under full load")
      .required()
      .one_of({"approx", "solver", "coverage", "switch", "loop", "jet", "truth"});
  sub.option("SCENE", options->scene, "Scene to take states from; default: the built-in one of each bench");
  sub.option("-o,--output", options->output, "Folder: approx.csv and .svg of approx, truth.svg of truth")
      .shows("DIR");
  sub.option(
         "--states", options->states,
         "bench solver, for large bodies: shrink the box towards rest until its lattice has at most\n"
         "N states; 1: a single state, its time and memory. bench loop: a lattice of at most N states is\n"
         "known at the start")
      .shows("N")
      .between(std::size_t{1}, std::size_t{1000000});
  sub.option("--seconds", options->seconds,
             "bench loop: length with and without the record of inputs, each [s]; default 120")
      .between(2.0, 86400.0);
  sub.option(
         "--blocks", options->blocks,
         "bench loop: sessions that this length is cut into; default 4. 1: one long session, for its memory")
      .between(1, 1000);
}

}  // namespace forefeel
