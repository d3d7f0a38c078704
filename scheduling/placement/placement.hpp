#pragma once
// As few states as a scene needs: each next state goes where the estimated error (placement_estimate.hpp) is
// largest.
//
// The model holds an error E over a box when 95 % of the box is within E and none of it beyond 2 E: estimated
// at 512 points of a Halton sequence for the share, and at these and a 7 x 7 x 7 grid up to the faces for the
// largest.
//   rest, four corners of a tetrahedron at 3/4 of the box, while needed its other four, then the point of the
//   largest estimate, until the estimate holds;
// then the truth is looked at: tight solves on the reference branch at random positions, and, for the
// largest, at corners, edges and faces of the box. Where it does not hold, the worst of them becomes a state
// (it is solved already) and placing goes on; where it does, but only after some of them became states,
// others are drawn, up to four times. What comes next depends
// on the states so far alone, so that a run that was cut goes on as if it had not been. A linear body takes
// three solves.
//
// Liver of 1725 tetrahedra, neo-Hookean, 2 cm patch, box 72 x 72 x 60 mm, quintic on force and stiffness: 8
// states hold 7 %, 22 hold 1 %. One-node contact: 49 hold 7 %.

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

// Where to solve next, on-line: of the candidates the one with the largest weight x estimated error. Where
// nothing can be estimated yet the error counts as 1 + (distance to the nearest state) / h. Candidates at
// known states and of weight 0 never win. nullopt where none is left. weights: as many as candidates, >= 0.
struct WorstPosition {
  std::size_t index = 0;  // of the candidate
  double estimate = 0;    // its estimated error [1], infinite where unknown
};
std::optional<WorstPosition> worst_position(ErrorEstimator& estimator, const StateSpace& space,
                                            std::span<const Vec3> candidates,
                                            std::span<const double> weights);

struct ErrorQuantiles {
  double p50 = unknown, p95 = unknown, max = unknown;  // [1]
  double held() const;                                 // the least E that is held: max(p95, max / 2)
};

struct PlacementOptions {
  double error = 0.01;              // E [1], > 0
  StateSpaceOptions space;          // box; spacing is the continuation step of the reference branch
  EstimateOptions estimate;         // the model whose error counts
  std::size_t max_states = 0;       // 0: as many as the lattice of the box would have
  std::size_t truth_samples = 100;  // 0: the truth is not looked at
  std::uint64_t seed = 0;           // of the truth's positions
  int threads = 0;                  // 0: all; the result does not depend on it
  bool want_displacements = false;
  std::stop_token stop;
};

struct PlacementReport {
  std::size_t states = 0;       // usable ones, those known before included
  std::size_t most_states = 0;  // that there may be: PlacementOptions::max_states, or what the lattice has
  std::size_t solved = 0, failed = 0, resumed = 0;
  std::size_t truth_solved = 0, truth_failed = 0;
  std::size_t truth_unsolved = 0;                    // of the positions of the truth: the stop came first
  bool linear = false;                               // three solves are the whole state space
  bool estimate_holds = false, truth_holds = false;  // truth_holds: also true where it was not looked at
  bool stopped = false;                              // by the stop token
  ErrorQuantiles estimate, truth;
  std::size_t truth_samples = 0;     // that truth is from
  std::size_t truth_on_surface = 0;  // and its largest besides: of the box
  bool truth_is_fresh = true;        // none of these positions decided where a state went
  double seconds = 0;
  int threads = 1;
};

struct PlacementProgress {
  std::size_t states = 0, most_states = 0;
  double estimate = unknown;                    // held so far, see ErrorQuantiles
  std::size_t truth_done = 0, truth_total = 0;  // while the truth is sampled
};

// known: states of this body, in the order in which they were placed. sink gets each new state as soon as it
// is solved, failed ones included (they are not tried again), from the calling thread.
PlacementReport place_states(std::shared_ptr<const Body> body, const PlacementOptions& options,
                             std::span<const State> known, const std::function<void(State)>& sink,
                             const std::function<void(const PlacementProgress&)>& progress);

// The relative errors of the model at the given truth: |f~ - f| / max(|f|, floor). Quantiles of the first
// `uniform`, the largest of all.
ErrorQuantiles true_error(ErrorEstimator& estimator, std::span<const State> truth, double floor,
                          std::size_t uniform = static_cast<std::size_t>(-1));

}  // namespace forefeel
