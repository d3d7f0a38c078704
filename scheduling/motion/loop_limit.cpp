#include "scheduling/motion/loop_limit.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace forefeel {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

double colgate_limit(const LoopPlant& plant, double frame, double virtual_damping) {
  return std::max(0.0, 2 * (plant.damping - std::abs(virtual_damping)) / frame);
}

double hulin_limit(const LoopPlant& plant, double frame, double delay, double virtual_damping) {
  return std::max(0.0, (plant.damping + virtual_damping) / (frame / 2 + delay));
}

double friction_limit(const LoopPlant& plant) {
  return plant.resolution > 0 ? 2 * plant.friction / plant.resolution : infinite;
}

// One frame maps y = (x, v) to A y + (I - A) (F / k, 0) with A = exp([0 1; -k/m -b/m] T). With F = -K x the
// determinant of the map is |A| + K (|A| - A_22) / k and its trace is tr A - K (1 - A_11) / k.
double sampled_limit(const LoopPlant& plant, double frame) {
  const double m = plant.mass, b = plant.damping, k = plant.stiffness;
  if (!(m > 0 && b >= 0 && k > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double rate = b / (2 * m);
  const std::complex<double> turn = std::sqrt(std::complex<double>(k / m - rate * rate));
  const double decay = std::exp(-rate * frame), c = std::cos(turn * frame).real() * decay,
               s = (std::abs(turn) > 0 ? (std::sin(turn * frame) / turn).real() : frame) * decay;
  const double a11 = c + rate * s, a22 = c - rate * s, det = decay * decay, trace = a11 + a22;
  double limit = infinite;
  if (det > a22) limit = std::min(limit, k * (1 - det) / (det - a22));
  if (const double slope = 1 - a11 + a22 - det; slope > 0)
    limit = std::min(limit, k * (1 + trace + det) / slope);
  return limit;
}

}  // namespace forefeel
