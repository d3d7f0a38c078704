#pragma once
// All states of the lattice {k h}^3 inside a box, each on the reference branch: the primary equilibrium path, followed
// from rest straight to the state.
//
//   StateSpace space({.spacing = 0.004, .box = reach});
//   generate(body, space);                            // its lattice

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "geometry/states/state.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

class StateSpace;

struct GenerateOptions {
  int threads = 0;          // 0: all
  double tolerance = 1e-6;  // force, relative
  bool want_displacements = false;
  int jet = 1;  // order of the force that a state keeps: with 2 to 4 also an energy jet
  std::stop_token stop = {};
};
struct LatticeOptions : GenerateOptions {
  double spacing = 0.006;  // h [m]
  Box box;                 // [m]
};
// What more threads could do. Each piece of work (a coarse state, or a few fine ones) waits only for the pieces that it
// starts from. work / path bounds the gain of any number of threads. With ranks all are 0.
struct ParallelTimes {
  double work = 0;  // [s], of all pieces and of what comes before them
  double path = 0;  // [s], the longest chain of pieces, or all calls of the sink if longer
  double idle = 0;  // [s], sum over the threads, without a piece to solve
};
struct GenerateReport {
  std::size_t solved = 0, failed = 0, resumed = 0;
  std::size_t inverted = 0;  // of the solved: with inverted elements (state_outcome.hpp)
  double seconds = 0;        // wall time [s]
  int threads = 0;
  ParallelTimes parallel;
};

// Adds to a space all states of its own lattice, with its spacing and box. States that it holds are not solved again;
// failed ones are only counted.
GenerateReport generate(const Body& body, StateSpace& space, const GenerateOptions& options = {});

// Solves every lattice point of the box that `known` does not hold, outward from rest. Failed states in
// `known` are not retried. sink(state) receives each new state, failed ones included; progress(done, total)
// reports. Both are called from one thread at a time.
// A state is marked multivalued if its straight path jumps within its last two steps, if another path ends at
// another equilibrium, or if its force differs from what the stiffnesses of its neighbours predict.
GenerateReport generate_lattice(std::shared_ptr<const Body> body, const LatticeOptions& options,
                                const std::function<void(State)>& sink,
                                const std::function<void(std::size_t, std::size_t)>& progress = {},
                                const std::vector<State>& known = {});

// The same at any places [m] in this order, each followed straight from rest by itself: several times the work of a
// lattice's states, whose neighbours start them.
GenerateReport generate_places(std::shared_ptr<const Body> body, std::span<const Vec3> places,
                               const LatticeOptions& options, const std::function<void(State)>& sink,
                               const std::function<void(std::size_t, std::size_t)>& progress = {},
                               const std::vector<State>& known = {});

}  // namespace forefeel
