#pragma once
// `spacing = "auto"`: finds the coarsest lattice on which the label safe implies an error below a tolerance.
//
// It is a reduced calibration of the label safe (densely known; says nothing of stability). For decreasing spacings
//   h = L/2, L/3, L/4, L/6, L/8, L/12, L/16, L/24,   L the longest side of the box,
// the lattice of the box is solved. The model is compared with tight solves on the reference branch at n =
// 200 positions, drawn independently and uniformly from the safe region. If the error exceeds the tolerance at k of
// them then, at 95 % confidence, it exceeds the tolerance in a share of the safe region of at most
//   b(k, n):  sum_{i <= k} C(n, i) b^i (1 - b)^(n - i) = 0.05        (Clopper, Pearson 1934, one-sided).
// The result is the first h with b <= 5 %, that is k <= 4 of 200. So, with 95 % confidence, at least 95 % of
// the safe region lies within the tolerance. The worst error is not bounded: only the largest one found is
// reported. Positions are evaluated in batches, and a spacing is rejected as soon as more than 4 exceed the tolerance;
// a spacing that is far too coarse costs a few dozen solves. If few positions of the box are safe, n and the allowed k
// are smaller (at least 59 positions, with k = 0). A safe position without an equilibrium counts as above the
// tolerance. The result depends on the arguments alone, not on threads or earlier solves.

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "approx/model/updater.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

struct AutoSpacingProgress {
  std::size_t trial = 0, trials = 0;  // the spacing that is tried, from 1; how many there are at most
  double spacing = 0;                 // h [m]
  bool checking = false;              // false: states of the lattice are solved; true: references
  std::size_t done = 0, total = 0;    // of these
};

struct AutoSpacingOptions {
  Box box;
  double tolerance = 0.07;  // of the error [1]
  ModelOptions model;
  CoverageOptions coverage{};
  double floor = 0.05;                             // f0 [N]
  std::size_t positions = 200;                     // safe positions to evaluate per spacing
  double allowed_share = 0.05;                     // of safe positions above the tolerance [1]
  double confidence = 0.95;                        // of that bound [1]
  int threads = 0;                                 // 0: all
  const std::atomic<bool>* interrupted = nullptr;  // once true, solving stops and the report is invalid
  std::function<void(const AutoSpacingProgress&)> progress = {};  // from one thread at a time
};

struct AutoSpacingTrial {
  double spacing = 0;  // h [m]
  std::size_t states = 0;
  std::size_t safe = 0, above = 0;      // positions evaluated; of these above the tolerance
  double share_bound = 1;               // b(above, safe) [1]
  double p95 = unknown, max = unknown;  // errors at the safe positions [1]
};

struct AutoSpacingReport {
  double spacing = 0;  // [m]; the finest one tried if none is good enough
  bool holds = false;
  bool interrupted = false;
  std::size_t solves = 0;                // states and references
  double seconds = 0;                    // wall time [s]
  std::vector<AutoSpacingTrial> trials;  // the last one is that of `spacing`
};

// The finest spacing that is tried in a box [m].
double finest_spacing(const Box& box);

AutoSpacingReport choose_spacing(std::shared_ptr<const Body> body, const AutoSpacingOptions& options);

// b(k, n) above; 1 where k >= n.
double share_bound(std::size_t k, std::size_t n, double confidence);

}  // namespace forefeel
