#pragma once
// `spacing = "auto"`: the coarsest lattice on which safe means an error below a tolerance.
//
// A calibration of the label safe, cut down to what a choice needs: for falling spacings
//   h = L/2, L/3, L/4, L/6, L/8, L/12, L/16, L/24,   L the longest side of the box,
// the lattice of the box is solved, and at those of 32 fixed positions (Halton, 2-3-5) that are safe on it
// the model is compared with tight solves on the reference branch. The first h is taken whose safe positions,
// 8 of them at least, all have an error of the tolerance or less; with all 32 safe that bounds P(error >
// tolerance | safe) below 9 % at 95 % confidence. Coarse lattices have few states and few safe positions, so
// that a smooth body costs some dozens of solves. Depends on its arguments alone, neither on threads nor on
// what was solved before.

#include <functional>
#include <memory>
#include <vector>

#include "approx/updater.hpp"
#include "solver/solver.hpp"

namespace forefeel {

struct AutoSpacingOptions {
  Box box;
  double tolerance = 0.07;  // of the error [1]
  ModelOptions model;
  CoverageOptions coverage{};
  double floor = 0.05;  // f0 [N]
  std::size_t positions = 32, least_safe = 8;
  int threads = 0;  // 0: all
};

struct AutoSpacingTrial {
  double spacing = 0;  // h [m]
  std::size_t states = 0, safe = 0;
  double p95 = unknown, max = unknown;  // errors at the safe positions [1]
};

struct AutoSpacingReport {
  double spacing = 0;  // [m]; the finest tried where none holds
  bool holds = false;
  std::size_t solves = 0;  // states and references
  double seconds = 0;
  std::vector<AutoSpacingTrial> trials;  // the last one is that of `spacing`
};

AutoSpacingReport choose_spacing(std::shared_ptr<const Body> body, const AutoSpacingOptions& options);

}  // namespace forefeel
