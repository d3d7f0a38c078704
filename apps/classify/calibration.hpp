#pragma once
// Do labels mean something? Known states are cut out of a lattice in several ways, so that every label has
// positions; at positions that are not states the model's error, against tight solves, stands beside the
// label, the distance delta to the nearest state and the power function P (approx/judge/power_function.hpp) of the
// set that the model used.
//   table   per kernel, data and label: P(error > tolerance | label) with its 95 % interval (Wilson 1927),
//           error quantiles
//   ranks   per kernel and data: Spearman's rank correlation of the true error with label (safe < sparse <
//           gap < blank), delta, spread (infinite counts as largest) and P
// Needs states and truth alone: no solver.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "approx/select/updater.hpp"

namespace forefeel {

struct CalibrationOptions {
  StateSpaceOptions space;       // spacing, box, thresholds
  Vec3 inward = -Vec3::UnitZ();  // the gap and the border of what is known are cut across it
  double tolerance = 0.07;       // of the error [1]
  double floor = 0.05;           // f0 [N]
  Select select = Select::label;
  std::uint64_t seed = 0;  // of the thinned sets
  int threads = 0;
};

struct CalibrationKind {
  std::string name;  // "r3, force, n 100"
  ModelOptions model;
};
std::vector<CalibrationKind> calibration_kinds(Select select);

struct KnownSet {
  std::string name;  // full, blank, gap, sparse, hole, thin, corner
  std::vector<State> states;
};
std::vector<KnownSet> calibration_sets(const std::vector<State>& pool, const CalibrationOptions& options);

struct CalibrationSample {
  std::size_t kind = 0, set = 0, position = 0;
  Label label = Label::blank;
  double delta = 0, spread = 0, power = 0;  // [m], [m], [m^(k/2)]
  double error = unknown;                   // [1]
};

struct CalibrationCell {  // of a kind and a label
  std::size_t kind = 0;
  Label label = Label::safe;
  std::size_t count = 0, over = 0;  // samples, those above the tolerance
  double p50 = unknown, p90 = unknown, p95 = unknown, p99 = unknown, max = unknown;
  double share = unknown, low = unknown, high = unknown;  // over / count, Wilson's interval
};

struct CalibrationRanks {  // Spearman's rho with the true error
  std::size_t kind = 0;
  double label = unknown, delta = unknown, spread = unknown, power = unknown;
};

struct Calibration {
  std::vector<CalibrationKind> kinds;
  std::vector<KnownSet> sets;              // without states
  std::array<std::size_t, 4> positions{};  // per label, over all sets
  std::vector<CalibrationSample> samples;
  std::vector<CalibrationCell> table;  // kind by kind, safe to blank
  std::vector<CalibrationRanks> ranks;
};

// pool: usable states; truth: usable states at positions of their own.
Calibration calibrate(const std::vector<State>& pool, const std::vector<State>& truth,
                      const CalibrationOptions& options);

// Spearman's rank correlation, ties at their mean rank; NaN pairs are left out, infinities are ranked.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);
struct ShareInterval {
  double low, high;
};
ShareInterval wilson_interval(std::size_t hits, std::size_t count);  // 95 %

struct Globals;
// `forefeel classify [STATES] --calibrate SCENE [-o DIR/]`. States: a file, or "" for the scene's lattice.
int calibrate_labels(const Globals& globals, const std::string& scene, const std::string& states,
                     const std::string& output);

}  // namespace forefeel
