#pragma once
// Finds jumps of a force along a path: the steepest steps are halved again and again. The change of a
// continuous force tends to zero; a jump remains.

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "geometry/coverage/state_space.hpp"

namespace forefeel::test {

// |f(b) - f(a)| after bisection down to rounding, always keeping the steeper half.
double left_of(const auto& force, Vec3& a, Vec3& b) {
  Vec3 fa = force(a), fb = force(b);
  for (int halving = 0; halving < 40; ++halving) {
    const Vec3 x = 0.5 * (a + b);
    if (x == a || x == b) break;
    const Vec3 f = force(x);
    if ((f - fa).norm() > (fb - f).norm()) {
      b = x;
      fb = f;
    } else {
      a = x;
      fa = f;
    }
  }
  return (fb - fa).norm();
}

struct Jump {
  double left = 0;     // [N]
  Vec3 at{0, 0, 0};    // there
  bool finite = true;  // all forces on the way
};

// The largest jump over the `count` steepest steps. Safe regions are left out, because sets change abruptly at their
// border.
Jump largest_jump(const StateSpace& space, const auto& force, const Vec3& from, const Vec3& to, double step,
                  std::size_t count) {
  const int steps = std::max(1, static_cast<int>((to - from).norm() / step));
  const auto at = [&](int i) { return Vec3(from + (to - from) * (double(i) / steps)); };
  std::vector<std::pair<double, int>> changes;
  Jump worst;
  Vec3 before = force(from);
  bool safe = space.label(from) == Label::safe;
  worst.finite = before.allFinite();
  for (int i = 1; i <= steps; ++i) {
    const Vec3 now = force(at(i));
    const bool was_safe = std::exchange(safe, space.label(at(i)) == Label::safe);
    worst.finite = worst.finite && now.allFinite();
    if (!safe && !was_safe) changes.emplace_back((now - before).norm(), i);
    before = now;
  }
  std::ranges::sort(changes, std::greater{});
  for (std::size_t k = 0; k < std::min(count, changes.size()); ++k) {
    Vec3 a = at(changes[k].second - 1), b = at(changes[k].second);
    const double left = left_of(force, a, b);
    // A step may pass through a corner of a safe region.
    if (space.label(a) == Label::safe || space.label(b) == Label::safe) continue;
    if (left > worst.left) {
      worst.left = left;
      worst.at = a;
    }
  }
  return worst;
}

}  // namespace forefeel::test
