#pragma once
// The benches of `forefeel-bench`. Each prints its rows and returns the exit code. An empty scene name
// selects the built-in scene.

#include <cstddef>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "geometry/common/declared.hpp"

namespace forefeel {

// folder: where approx.csv and approx.svg are written; "" writes no file.
int bench_approx(const Globals& globals, const std::string& scene, const std::string& folder);
int bench_coverage(const Globals& globals);
// most_states: largest number of states to solve; 0 means the scene's whole lattice.
int bench_solver(const Globals& globals, const std::string& scene, std::size_t most_states);
int bench_switch(const Globals& globals, const std::string& scene);
int bench_jet(const Globals& globals, const std::string& scene);
// folder: where truth.svg is written; "" writes no file. Without a scene: all phantoms.
int bench_truth(const Globals& globals, const std::string& scene, const std::string& folder);
// folder: where scale.svg is written; "" writes no file. full: sizes that take half an hour on two cores.
int bench_scale(const Globals& globals, const std::string& scene, const std::string& folder, bool full);

struct LoopBench {
  double seconds = 120;    // of each kind: with and without the record of inputs [s]
  int blocks = 4;          // sessions of each kind
  std::size_t states = 0;  // known at the start, at most; 0: the sessions begin as the scene says
};
int bench_loop(const Globals& globals, const std::string& scene, const LoopBench& bench);

// The keys that they print with --json.
DeclaredTable declared_bench_approx();
DeclaredTable declared_bench_coverage();
DeclaredTable declared_bench_solver();
DeclaredTable declared_bench_switch();
DeclaredTable declared_bench_loop();
DeclaredTable declared_bench_jet();
DeclaredTable declared_bench_truth();
DeclaredTable declared_bench_scale();
std::vector<DeclaredTable> declared_bench_json();  // of all

}  // namespace forefeel
