#pragma once
// Parts of `forefeel bench approx`: the states and references it measures with, what it times, and the picture
// of speed against error.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "geometry/coverage/state_space.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel::bench {

// A full lattice of states, and tight solves elsewhere to judge by.
struct Case {
  std::shared_ptr<const Body> body;
  StateSpaceOptions options;
  std::string name;
  std::vector<State> states;
  Box reach;                  // of the lattice that was filled: the box, or less where it is no multiple of h
  std::vector<State> inside;  // at random positions of that
  double front = 0;           // known half-space x <= front [m], a lattice plane
  // At random positions of the planes this far beyond the front; none where the box does not reach.
  struct Outside {
    double distance;  // [m]
    std::vector<State> references;
  };
  std::vector<Outside> outside;
  std::vector<std::string> notes;  // what could not be had, one a line
};

Case take_case(const Globals& globals, const std::string& scene, Progress& progress);

struct Errors {
  double p50 = unknown, p95 = unknown, max = unknown;
};

// What one method with one n does; times in microseconds, unknown where it has no such step.
struct Measured {
  std::string method;
  std::size_t n = 0;
  double refit = unknown, evaluate = unknown;
  double update[3] = {unknown, unknown, unknown};  // k = 1, 5, 20
  Errors inside;
  std::vector<Errors> outside;                            // as Case::outside
  std::optional<std::size_t> states_for_1, states_for_7;  // fewest whose p95 is below 1 % and 7 %
};

double now_us();

// Pareto front: nothing faster is as exact. Two panels, evaluation and update (k = 5; refit where there is none).
std::string pareto_plot(const std::vector<Measured>& all);
std::string table_csv(const Case& bench, const std::vector<Measured>& all);

}  // namespace forefeel::bench
