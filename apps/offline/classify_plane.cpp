// States in a plane: labelled in it.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/console/console.hpp"
#include "apps/offline/classify.hpp"
#include "geometry/common/dense.hpp"

namespace forefeel {

std::vector<Vec3> Classified::places() const {
  std::vector<Vec3> all;
  all.reserve(states.size() + beside.size());
  for (const State& state : states) all.push_back(turn * state.at);
  for (const Vec3& x : beside) all.push_back(turn * x);
  return all;
}

Coverage Classified::coverage(const Vec3& q) const {
  Coverage found = index.space ? index.space->coverage(turn * q) : index.octree->coverage(turn * q);
  if (beside.empty()) return found;
  double least = std::numeric_limits<double>::infinity();
  for (const State& s : states) least = std::min(least, (s.at - q).squaredNorm());
  found.delta = std::sqrt(least);
  return found;
}

void lay_flat(Classified& set) {
  const Vec3 normal = (set.states[0].at - set.beside[0]).normalized();
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  if (std::abs(normal[axis]) > 1 - 1e-9) return;
  const Vec3 up = std::copysign(1.0, normal[axis]) * Vec3::Unit(axis);
  const Mat3 upright = turn_between(normal, up);
  double least = std::numeric_limits<double>::infinity();
  for (int degrees = 0; degrees < 90; ++degrees) {
    const Mat3 turn = Eigen::AngleAxisd(degrees * M_PI / 180, up) * upright;
    Vec3 low = turn * set.states[0].at, high = low;
    for (const State& s : set.states) {
      const Vec3 x = turn * s.at;
      low = low.cwiseMin(x), high = high.cwiseMax(x);
    }
    const Vec3 half = set.spacing / 8 * Vec3::Unit(axis);
    const Box box{low - half, high + half};
    if (box.size().prod() < least) least = box.size().prod(), set.turn = turn, set.box = box;
  }
}

void take_plane(Classified& set, bool have_box, const std::string& where, const Globals& globals) {
  constexpr double flat = 0.01, thin = 0.1,
                   wide = 0.5;  // of the spacing: deviations across the plane, along it
  if (set.states.size() < 4 || set.lattice) return;
  const auto n = static_cast<double>(set.states.size());
  Vec3 middle = Vec3::Zero();
  for (const State& s : set.states) middle += s.at / n;
  Mat3 spread = Mat3::Zero();
  for (const State& s : set.states) spread += (s.at - middle) * (s.at - middle).transpose() / n;
  const Modes3 modes = axes_of(spread);
  const double h = set.spacing;
  if (modes.values[1] < flat * flat * h * h && modes.values[2] > 0)
    warn(globals, where +
                      ": the states lie on a line, so no volume is labelled; --points tells the labels of "
                      "places along it");
  if (!(modes.values[0] < thin * thin * h * h) || !(modes.values[1] > wide * wide * h * h)) return;
  if (!(modes.values[0] < flat * flat * h * h))
    return warn(globals,
                fmt::format("{}: the states are thin: {:.2g} mm off a plane (standard deviation) with a "
                            "spacing of {:.3g} mm; nothing is known across it",
                            where, 1e3 * std::sqrt(modes.values[0]), 1e3 * h));
  const Vec3 normal = modes.vectors.col(0);
  for (const double side : {-h, h})
    for (const State& s : set.states) set.beside.push_back(s.at + side * normal);
  if (!have_box) {
    const Vec3 half = h / 8 * normal.cwiseAbs();
    set.box = {set.box.low - half, set.box.high + half};
  }
  warn(globals,
       fmt::format("{}: the states lie in a plane: they are labelled in it, as a layer {:.3g} mm thick",
                   where, 1e3 * h / 4));
}

}  // namespace forefeel
