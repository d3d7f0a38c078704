#pragma once
// Parts of `forefeel-bench approx`: its states and references, the times it measures, its tables, and the
// picture of speed against error.

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/bench_row.hpp"
#include "apps/console/console.hpp"
#include "geometry/coverage/state_space.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel::bench {

// A full lattice of states, and tight solves at other positions, which are the references for errors.
struct Case {
  std::shared_ptr<const Body> body;
  StateSpaceOptions options;
  std::string name;
  std::vector<State> states;
  Box reach;                  // extent of the lattice: the scene's box, rounded down to multiples of h
  std::vector<State> inside;  // references at random positions in reach
  double front = 0;           // known half-space x <= front [m], a lattice plane
  // References at random positions of planes beyond the front; none where a plane lies outside the box.
  struct Outside {
    double distance;  // [m]
    std::vector<State> references;
  };
  std::vector<Outside> outside;
  std::vector<std::string> notes;  // what could not be measured, one note a line
};

Case take_case(const Globals& globals, const std::string& scene, Progress& progress);

struct Errors {
  double p50 = unknown, p95 = unknown, max = unknown;
};

// Results of one method with n neighbours. Times in microseconds; unknown if the method has no such step.
struct Measured {
  std::string method;
  std::size_t n = 0;
  double refit = unknown, evaluate = unknown;
  double update[3] = {unknown, unknown, unknown};  // k = 1, 5, 20
  Errors inside;
  std::vector<Errors> outside;                            // as Case::outside
  std::optional<std::size_t> states_for_1, states_for_7;  // fewest whose p95 is below 1 % and 7 %
};

// Number of states replaced in each timed update (Measured::update).
constexpr std::size_t replacements[3] = {1, 5, 20};

// Time of one method compared with a baseline; medians [us].
struct Comparison {
  std::string name, baseline;  // "update r3", "own refit"
  double ours = unknown;
  BenchTime theirs = {unknown, unknown};
  Errors error;  // of the method, inside
  std::size_t n = 0;
  std::optional<std::size_t> k = {};  // replaced states, of an update
  double by_refit = unknown;          // share of the updates that were made by a refit
};

// The tables as text (known: states of the lattice), and the document of --json.
void print_tables(const Globals& globals, const Case& taken, std::size_t known,
                  const std::vector<Comparison>& rows, const std::vector<Measured>& table);
nlohmann::ordered_json document_of(const Case& taken, const std::vector<Comparison>& rows,
                                   const std::vector<Measured>& table, const std::vector<std::string>& notes);

// Draws the Pareto front: no faster method has as small an error. Two panels: evaluation, and update with k =
// 5 (or refit, for a method without updates).
std::string pareto_plot(const std::vector<Measured>& all);
std::string table_csv(const Case& bench, const std::vector<Measured>& all);

}  // namespace forefeel::bench
