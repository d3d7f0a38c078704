#pragma once
// `spacing = "auto"`: the coarsest lattice on which safe means an error below a tolerance.
//
// A calibration of the label safe, cut down to what a choice needs: for falling spacings
//   h = L/2, L/3, L/4, L/6, L/8, L/12, L/16, L/24,   L the longest side of the box,
// the lattice of the box is solved, and at n = 200 positions, drawn independently and evenly among those that
// are safe on it, the model is compared with tight solves on the reference branch. With k of them above the
// tolerance the share p of all safe positions that are above it is, at 95 % confidence, at most
//   b(k, n):  sum_{i <= k} C(n, i) b^i (1 - b)^(n - i) = 0.05        (Clopper, Pearson 1934, one-sided).
// The first h is taken with b <= 5 %: k <= 4 of 200. That is the claim: with 95 % confidence at least 95 % of
// what is safe lies within the tolerance; of the worst error it says nothing but what was met. Positions are
// judged some at a time and a spacing is left when more than 4 are above, so that spacings far too coarse
// cost some dozens of solves. Where few positions of the box are safe n is smaller and k with it (59 and none
// at the least). A safe position without an equilibrium counts as above. Depends on its arguments alone,
// neither on threads nor on what was solved before.

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "approx/select/updater.hpp"
#include "solver/equilibrium/solver.hpp"

namespace forefeel {

struct AutoSpacingOptions {
  Box box;
  double tolerance = 0.07;  // of the error [1]
  ModelOptions model;
  CoverageOptions coverage{};
  double floor = 0.05;          // f0 [N]
  std::size_t positions = 200;  // safe ones that a spacing is judged by
  double allowed_share = 0.05;  // of safe positions above the tolerance [1]
  double confidence = 0.95;     // with which they are no more [1]
  int threads = 0;              // 0: all
  const std::atomic<bool>* interrupted =
      nullptr;  // once true, what is left is not solved, and the report is of no use
};

struct AutoSpacingTrial {
  double spacing = 0;  // h [m]
  std::size_t states = 0;
  std::size_t safe = 0, above = 0;      // positions judged; of these above the tolerance
  double share_bound = 1;               // b(above, safe) [1]
  double p95 = unknown, max = unknown;  // errors at the safe positions [1]
};

struct AutoSpacingReport {
  double spacing = 0;  // [m]; the finest tried where none holds
  bool holds = false;
  bool interrupted = false;
  std::size_t solves = 0;  // states and references
  double seconds = 0;
  std::vector<AutoSpacingTrial> trials;  // the last one is that of `spacing`
};

AutoSpacingReport choose_spacing(std::shared_ptr<const Body> body, const AutoSpacingOptions& options);

// b(k, n) above; 1 where k >= n.
double share_bound(std::size_t k, std::size_t n, double confidence);

}  // namespace forefeel
