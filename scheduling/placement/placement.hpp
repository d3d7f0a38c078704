#pragma once
// Covers a scene with few states: each next state is placed where the estimated error
// (placement_estimate.hpp) is largest.
//
// The model holds an error E over a box if 95 % of the box is within E and all of it within 2 E. The share is
// estimated at 512 points of a Halton sequence; the largest error at these and at a 7 x 7 x 7 grid that
// includes the faces. The order of states is:
//   rest; four corners of the box scaled by 3/4, which form a tetrahedron; its other four, if needed; then the point of
//   the largest estimate, until the estimate holds.
// Then the true error is checked by tight solves on the reference branch at random positions and, for the
// largest error, at corners, edges and faces of the box. If it is above E, the worst position becomes a state (it is
// solved already) and placement continues. If it is within E, but some of these positions have become states, new
// positions are drawn, up to four times. The next state depends only on the states so far, so an interrupted run can be
// resumed with the same result. A linear body takes three solves.
//
// Liver of 1725 tetrahedra, neo-Hookean, 2 cm patch, box 72 x 72 x 60 mm, quintic on force and stiffness: 8
// states hold 7 %, 22 states hold 1 %. With a one-node contact 49 states hold 7 %.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "geometry/coverage/state_space.hpp"
#include "scheduling/placement/placement_estimate.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

// The candidate to solve next in a session: the one with the largest weight x estimated error. If no estimate is
// possible yet, the error counts as 1 + (distance to the nearest state) / h. Candidates at known states or of weight 0
// are never chosen; nullopt if no other is left. weights: #candidates, >= 0.
struct WorstPosition {
  std::size_t index = 0;  // of the candidate
  double estimate = 0;    // its estimated error [1]; infinite if unknown
};
std::optional<WorstPosition> worst_position(ErrorEstimator& estimator, const StateSpace& space,
                                            std::span<const Vec3> candidates,
                                            std::span<const double> weights);

struct ErrorQuantiles {
  double p50 = unknown, p95 = unknown, max = unknown;  // [1]
  double held() const;                                 // the least E that holds: max(p95, max / 2)
};

struct PlacementOptions {
  double error = 0.01;              // E [1], > 0
  StateSpaceOptions space;          // box; spacing is the continuation step of the reference branch
  EstimateOptions estimate;         // the model whose error is estimated
  std::size_t max_states = 0;       // 0: as many as the lattice of the box has
  std::size_t truth_samples = 100;  // 0: no check of the true error
  std::uint64_t seed = 0;           // of the truth's positions
  int threads = 0;                  // 0: all; does not affect the result
  bool want_displacements = false;
  int jet = 1;  // order of the force that states keep
  std::stop_token stop;
};

// The model's error against tight solves at positions of the box.
struct PlacementTruth {
  std::size_t solved = 0, failed = 0;
  std::size_t unsolved = 0;    // positions not solved because of the stop
  std::size_t samples = 0;     // random positions behind `error`
  std::size_t on_surface = 0;  // more positions on the surface, for its maximum
  std::vector<State> checks;   // the solves at the random positions that did not become states
  bool is_fresh = true;        // none of these positions influenced the placement
  bool holds = false;          // the error is at most E; also true if unchecked
  ErrorQuantiles error;
};

struct PlacementReport {
  std::size_t states = 0;       // usable states, including those known before
  std::size_t most_states = 0;  // limit: PlacementOptions::max_states, or the lattice's number
  std::size_t solved = 0, failed = 0, resumed = 0;
  bool linear = false;  // three solves are the whole state space
  bool estimate_holds = false;
  bool stopped = false;  // by the stop token
  ErrorQuantiles estimate;
  PlacementTruth truth;
  double seconds = 0;  // wall time [s]
  int threads = 1;
};

struct PlacementProgress {
  std::size_t states = 0, most_states = 0;
  double estimate = unknown;                    // error held so far, see ErrorQuantiles::held()
  std::size_t truth_done = 0, truth_total = 0;  // while the truth is sampled
};

// known: states of this body, in the order of their placement. sink receives each new state as soon as it is
// solved, on the calling thread. It also receives failed states; they are not tried again.
PlacementReport place_states(std::shared_ptr<const Body> body, const PlacementOptions& options,
                             std::span<const State> known, const std::function<void(State)>& sink,
                             const std::function<void(const PlacementProgress&)>& progress);

// The relative errors |f~ - f| / max(|f|, floor) of the model at the states `truth`: quantiles over the first
// `uniform` states, maximum over all.
ErrorQuantiles true_error(ErrorEstimator& estimator, std::span<const State> truth, double floor,
                          std::size_t uniform = static_cast<std::size_t>(-1));

}  // namespace forefeel
