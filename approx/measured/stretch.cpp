#include "approx/measured/stretch.hpp"

#include <cmath>
#include <limits>

#include "geometry/common/dense.hpp"

namespace forefeel {
namespace {

constexpr double fewest_deviations = 0.05;  // of a direction that tells, in the largest deviation
constexpr int stretch_steps = 8;            // of the search for l, a and sigma at one A
constexpr double a_gain = 0.5;              // of the log likelihood, by a step
constexpr double sure_gain = 6;             // by all: two lengths more are worth 2 by chance (Akaike 1974)

}  // namespace

MeasuredRows stretched(MeasuredRows rows, const Mat3& by) {
  for (Vec3& x : rows.at) x = by * x;
  return rows;
}

Mat3 likely_stretch(const MeasuredRows& rows, const FieldLaw& law, std::optional<double> noise) {
  const auto count = static_cast<double>(rows.size());
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : rows.at) middle += x / count;
  Mat3 spread = Mat3::Zero();
  for (const Vec3& x : rows.at) spread += (x - middle) * (x - middle).transpose() / count;
  const Modes3 axes = axes_of(spread);
  const Mat3& directions = axes.vectors;
  const auto stretch_of = [&](const Vec3& by) -> Mat3 {
    return directions * (by / std::cbrt(by.prod())).asDiagonal() * directions.transpose();
  };
  const auto unlikely = [&](const Vec3& by) {
    const auto found =
        improved_law(stretched(rows, stretch_of(by)), law, {.steps = stretch_steps, .noise = noise});
    return found ? found->minus_log_likelihood : std::numeric_limits<double>::infinity();
  };
  Vec3 best = Vec3::Ones();
  double least = unlikely(best);
  const double alike = least;
  for (const double step : {2.0, 2.0, 2.0, 1.4}) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!(axes.values[axis] > fewest_deviations * fewest_deviations * axes.values[2])) continue;
      for (const double factor : {step, 1 / step}) {
        Vec3 tried = best;
        tried[axis] *= factor;
        if (const double value = unlikely(tried); value < least - a_gain) {
          least = value;
          best = tried;
          break;
        }
      }
    }
  }
  return alike - least > sure_gain ? stretch_of(best) : Mat3::Identity();
}

}  // namespace forefeel
