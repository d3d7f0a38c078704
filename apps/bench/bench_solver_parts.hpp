#pragma once
// Parts of `forefeel-bench solver`: the baselines on a sample of the lattice, and the errors of our states.
//
// A baseline is timed by the wall and by the processor time of the thread that solves. Where the two differ by more
// than 20 %, the thread waited for a processor, and its row does not count; nor does one of a baseline that failed.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/bench/newton_baseline.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/coverage/state_space.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

struct BenchCase {
  std::shared_ptr<const Body> body;
  StateSpaceOptions space;
  std::string name;
};

inline constexpr double bench_tolerance = 1e-6;

using ShowShare = std::function<void(double)>;  // of a part of the bench

struct Errors {
  std::vector<double> values;   // of states on the reference branch
  std::size_t multivalued = 0;  // states drawn that are an equilibrium of another branch
  double off_branch = 0;        // largest relative difference of their force from the reference branch
  double at(double share) const { return quantile_of(values, share); }
};

// Relative force errors of a random sample of states against tight solves on the reference branch, as many as fit into
// the time for errors. A state that stays off the reference branch when it is solved tightly from its own displacements
// is one of another branch, and no error of the solver.
Errors sample_errors(const BenchCase& bench, const std::vector<State>& states, std::uint64_t seed,
                     int threads, const ShowShare& show);

struct BaselineRun {
  double per_state = 0;        // [s] of a solved state, all threads together
  double processor_share = 1;  // of the time that its threads took: below 1 where they waited for a processor
  std::size_t states = 0, failed = 0;
  double iterations = 0;
  double factor_bytes = unknown;  // of one solver
  std::vector<State> solved;
};

// Solves the sample, each state from the displacements of its neighbour one spacing nearer to rest. The time
// of the neighbours does not count. No state is started after `budget` seconds.
BaselineRun run_baseline(Baseline which, const BenchCase& bench, const std::vector<State>& states,
                         const std::vector<std::size_t>& sample, int threads, double budget,
                         const ShowShare& show);

}  // namespace forefeel
