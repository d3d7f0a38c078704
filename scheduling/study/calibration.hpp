#pragma once
// Measures how well a label (coverage class) predicts the error on a given body. Several subsets of a lattice (known
// sets) are used, so that every label occurs. At positions that are not states, the relative error of the model is
// |f~ - f| / max(|f|, f0), with f the true force there. It is compared with four quantities: the label, the distance
// delta to the nearest state, the spread sqrt(R^2 - d^2) (Waldron's factor of the linear interpolation error), and the
// power function P (approx/error/leave_one_out.hpp) of the states in the model.
//   table   per kernel, data and label: P(error > tolerance | label) with its 95 % interval (Wilson 1927),
//           and error quantiles
//   ranks   per kernel and data: Spearman's rank correlation of the error with label (safe < sparse < gap <
//           blank), delta, spread (infinite counts as largest) and P
// Takes states and truth as input; solves nothing.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "approx/model/updater.hpp"

namespace forefeel {

struct CalibrationOptions {
  StateSpaceOptions space;       // spacing, box, thresholds
  Vec3 inward = -Vec3::UnitZ();  // into the body; gaps and borders of known sets lie perpendicular to it
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
  double error = unknown;                   // relative error of the model [1]
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
  std::vector<KnownSet> sets;        // without states
  ByLabel<std::size_t> positions{};  // over all sets
  std::vector<CalibrationSample> samples;
  std::vector<CalibrationCell> table;  // kind by kind, safe to blank
  std::vector<CalibrationRanks> ranks;
};

// Random positions in the box for the truth [m]. The same seed gives the same positions.
std::vector<Vec3> calibration_positions(const Box& box, std::size_t count, std::uint64_t seed);

// If nothing may be solved, a part of the states is used as truth: a fifth of them, at most `most`, in whole groups of
// neighbouring positions (approx/measured/position_groups.hpp; with more than 20,000 states, single positions). The
// rest is the pool. The same seed holds out the same states.
struct HeldOut {
  std::vector<State> pool, truth;
};
HeldOut hold_out(std::vector<State> states, std::size_t most, std::uint64_t seed);

// pool: usable states, from which the known sets are taken. truth: usable states at other positions.
Calibration calibrate(const std::vector<State>& pool, const std::vector<State>& truth,
                      const CalibrationOptions& options);

// Spearman's rank correlation. Ties get their mean rank; pairs with NaN are ignored, infinities are ranked.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);
struct ShareInterval {
  double low, high;
};
ShareInterval wilson_interval(std::size_t hits, std::size_t count);  // 95 %

}  // namespace forefeel
