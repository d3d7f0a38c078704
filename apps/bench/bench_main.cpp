// forefeel-bench approx|solver|coverage|switch|loop|jet|truth|scale [SCENE]: speed, error and ratios to named baselines
// measured in the same run.

#include <memory>
#include <string>
#include <utility>

#include "apps/bench/bench.hpp"
#include "apps/console/command.hpp"
#include "apps/console/console.hpp"
#include "apps/main/program.hpp"
#include "apps/scene/scene.hpp"

namespace forefeel {
namespace {

// What any bench may be given.
struct BenchArguments {
  std::string scene, output;
  std::size_t states = 0;
  bool full = false;
  LoopBench loop;
};

// A bench with the option SCENE. `run` gets the arguments.
template <class Run>
std::pair<Command, BenchArguments&> add(CommandLine& line, const std::string& name,
                                        const std::string& meaning, Run run) {
  const auto arguments = std::make_shared<BenchArguments>();
  Command sub = line.add(name, meaning);
  sub.runs([arguments, run](const Globals& globals) { return run(globals, *arguments); });
  sub.option("SCENE", arguments->scene, "Scene to take states from [the built-in one of the bench]");
  return {std::move(sub), *arguments};
}

void add_approx(CommandLine& line) {
  auto [sub, arguments] = add(line, "approx", "Fit, update and evaluation of the models: time and error",
                              [](const Globals& globals, const BenchArguments& given) {
                                return bench_approx(globals, given.scene, given.output);
                              });
  sub.option("-o,--output", arguments.output, "Folder for approx.csv and approx.svg").shows("DIR");
}

void add_solver(CommandLine& line) {
  auto [sub, arguments] = add(line, "solver", "States of a lattice beside full Newton",
                              [](const Globals& globals, const BenchArguments& given) {
                                return bench_solver(globals, given.scene, given.states);
                              });
  sub.option("--states", arguments.states,
             "For large bodies: shrink the box towards rest until its lattice has at most N states; 1: a "
             "single state, its time and memory")
      .shows("N")
      .between(std::size_t{1}, std::size_t{1000000});
}

void add_coverage(CommandLine& line) {
  Command sub = line.add("coverage", "Labels and indices beside CGAL and nanoflann; draws its own states");
  sub.runs([](const Globals& globals) { return bench_coverage(globals); });
  sub.reads_no_scene();
}

void add_switch(CommandLine& line) {
  add(line, "switch", "A frame under each switch rule, and what the hand feels of it",
      [](const Globals& globals, const BenchArguments& given) { return bench_switch(globals, given.scene); });
}

void add_jet(CommandLine& line) {
  add(line, "jet", "The energy jet at rest alone, its errors and its cost",
      [](const Globals& globals, const BenchArguments& given) { return bench_jet(globals, given.scene); });
}

void add_truth(CommandLine& line) {
  auto [sub, arguments] =
      add(line, "truth", "The whole error of a force, mesh and contact included, against what a state costs",
          [](const Globals& globals, const BenchArguments& given) {
            return bench_truth(globals, given.scene, given.output);
          });
  sub.option("-o,--output", arguments.output, "Folder for truth.svg").shows("DIR");
}

void add_scale(CommandLine& line) {
  auto [sub, arguments] = add(
      line, "scale", "generate, classify and evaluate against threads and sizes, beside CHOLMOD and SciPy",
      [](const Globals& globals, const BenchArguments& given) {
        return bench_scale(globals, given.scene, given.output, given.full);
      });
  sub.option("-o,--output", arguments.output, "Folder for scale.svg").shows("DIR");
  sub.flag("--full", arguments.full, "Up to a million states: half an hour on two cores");
}

void add_loop(CommandLine& line) {
  auto [sub, arguments] = add(line, "loop",
                              "The 1 kHz loop of a session beside a bare loop that only waits for its "
                              "deadlines, at the same time and under full load",
                              [](const Globals& globals, const BenchArguments& given) {
                                return bench_loop(globals, given.scene, given.loop);
                              });
  sub.option("--states", arguments.loop.states, "A lattice of at most N states is known at the start")
      .shows("N")
      .between(std::size_t{1}, std::size_t{1000000});
  sub.option("--seconds", arguments.loop.seconds, "Length with and without the record of inputs, each [s]")
      .shows_default()
      .between(2.0, 86400.0);
  sub.option("--blocks", arguments.loop.blocks,
             "Sessions that this length is cut into; 1: one long session, for its memory")
      .shows_default()
      .between(1, 1000);
}

std::vector<HelpTopic> bench_topics() {
  return {{"outputs", "The documents of --json.", declared_bench_json()}};
}

}  // namespace

}  // namespace forefeel

int main(int argc, char** argv) {
  using namespace forefeel;
  return program_main({.name = "forefeel-bench",
                       .description = "Speed and error beside named baselines in the same run",
                       .groups = {{"Benches",
                                   "forefeel-bench approx",
                                   {add_approx, add_solver, add_coverage, add_switch, add_jet, add_truth,
                                    add_scale, add_loop}}},
                       .topics = bench_topics},
                      argc, argv);
}
