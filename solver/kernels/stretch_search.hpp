#pragma once
// The material limit of an energy jet (solver/jet/jet_maker.hpp): how far the jet's own displacement can go before an
// element's least principal stretch falls below the limit of its law. Include in kernel files only (element_lanes.hpp).

#include "solver/kernels/element_loops.hpp"

namespace forefeel {
namespace {

constexpr int pair_from[6] = {0, 1, 2, 0, 0, 1}, pair_to[6] = {0, 1, 2, 1, 2, 2};

FOREFEEL_INLINE Lanes dot9(const Lanes* a, const Lanes* b) {
  Lanes sum = a[0] * b[0];
  for (int i = 1; i < 9; ++i) sum += a[i] * b[i];
  return sum;
}

FOREFEEL_INLINE bool any_below(Lanes a, Lanes b) {
  const LaneBits bits = a < b;
  long long all = 0;
  for (int e = 0; e < lane_count; ++e) all |= bits[e];
  return all != 0;
}

// G_1 and G_2 of one direction, from the gradients of U and of V; b null: V is 0.
FOREFEEL_INLINE void along_way(const double* x, const Lanes (*a)[9], const Lanes (*b)[9], Lanes* g1,
                               Lanes* g2) {
  for (int i = 0; i < 9; ++i) g1[i] = x[0] * a[0][i] + x[1] * a[1][i] + x[2] * a[2][i];
  for (int i = 0; i < 9; ++i) g2[i] = Lanes{};
  if (!b) return;
  for (int c = 0; c < 6; ++c) {
    const double product = x[pair_from[c]] * x[pair_to[c]];
    if (product != 0)
      for (int i = 0; i < 9; ++i) g2[i] += product * b[c][i];
  }
}

FOREFEEL_INLINE Lanes root(Lanes a) {
  Lanes r;
  for (int e = 0; e < lane_count; ++e) r[e] = __builtin_sqrt(a[e]);
  return r;
}

// Finds the least |d|, over directions and their opposites, at which F + G_1(d) + G_2(d, d) of a point has a principal
// stretch below Law::least_stretch (solver/jet/jet_maker.hpp). A direction is first tested at the least distance known;
// only where the test fails is the crossing found, by bisection.
template <class Law>
struct StretchSearch {
  static constexpr bool wanted = Law::of_invariants && Law::least_stretch > 0;
  double reached;  // the least distance known

  explicit StretchSearch(const JetDirections& d) : reached(d.reached ? *d.reached : __builtin_inf()) {}
  void give(const JetDirections& d) const {
    if (d.reached) *d.reached = reached;
  }

  // Not below zero where all stretches of f + t g1 + t^2 g2 are at least the limit and J > 0: the least of the leading
  // minors of C - limit^2 I, and J.
  static FOREFEEL_INLINE Lanes room(const Point<Lanes>& p, const Lanes* g1, const Lanes* g2, Lanes t) {
    constexpr double least_square = Law::least_stretch * Law::least_stretch;
    Lanes f[9], k[9];
    for (int i = 0; i < 9; ++i) f[i] = p.f[i] + t * (g1[i] + t * g2[i]);
    cofactor(f, k);
    const auto product = [&](int a, int b) {
      return f[a] * f[b] + f[a + 3] * f[b + 3] + f[a + 6] * f[b + 6];
    };
    const Lanes c00 = product(0, 0) - least_square, c11 = product(1, 1) - least_square,
                c22 = product(2, 2) - least_square, c01 = product(0, 1), c02 = product(0, 2),
                c12 = product(1, 2);
    const Lanes second = c00 * c11 - c01 * c01;
    const Lanes third = c22 * second - c00 * c12 * c12 - c11 * c02 * c02 + 2.0 * c01 * c02 * c12;
    return least(least(c00, second), least(third, f[0] * k[0] + f[1] * k[1] + f[2] * k[2]));
  }
  // |t G_1 + t^2 G_2|^2 at the least distance known, for d and for its opposite.
  FOREFEEL_INLINE Lanes change2(Lanes first2, Lanes cross, Lanes second2, double length) const {
    const double t = reached / length;
    return (t * t) * (first2 + t * (2.0 * (cross < 0.0 ? -cross : cross) + t * second2));
  }
  // room2: (least stretch - limit)^2 of F. A change of F by less cannot reach the limit.
  FOREFEEL_INLINE void visit(const Point<Lanes>& p, const Lanes* g1, const Lanes* g2, Lanes room2,
                             double length) {
    if (!__builtin_isinf(reached) &&
        !any_below(room2, change2(dot9(g1, g1), dot9(g1, g2), dot9(g2, g2), length)))
      return;
    search(p, g1, g2, length);
    Lanes opposite[9];
    for (int i = 0; i < 9; ++i) opposite[i] = -g1[i];
    search(p, opposite, g2, length);
  }
  // All directions. b: null where V is 0.
  __attribute__((noinline)) void all(const Point<Lanes>& p, const JetDirections& directions,
                                     const Lanes (*a)[9], const Lanes (*b)[9]) {
    const Lanes room2 = margin2(p);
    for (int k = 0; k < directions.count; ++k) {
      Lanes g1[9], g2[9];
      along_way(directions.ways + 3 * k, a, b, g1, g2);
      visit(p, g1, g2, room2, directions.lengths[k]);
    }
  }
  // |G_1|^2 along any d is at most this times |d|^2: Gershgorin's bound of the Gram matrix of the columns of grad U.
  static FOREFEEL_INLINE Lanes most_first2(const Lanes (*a)[9]) {
    Lanes row[3];
    for (int c = 0; c < 3; ++c) row[c] = dot9(a[c], a[c]);
    for (int c = 3; c < 6; ++c) {
      const Lanes product = dot9(a[pair_from[c]], a[pair_to[c]]), size = product < 0.0 ? -product : product;
      row[pair_from[c]] += size, row[pair_to[c]] += size;
    }
    const Lanes two = row[0] > row[1] ? row[0] : row[1];
    return two > row[2] ? two : row[2];
  }
  static FOREFEEL_INLINE Lanes hardness(const Point<Lanes>& p, const Lanes (*a)[9]) {
    const Lanes room2 = margin2(p);
    return most_first2(a) / (room2 > 1e-300 ? room2 : spread<Lanes>(1e-300));
  }
  // True if some direction may reach the limit within the least distance known. |G_2|^2 is at most |d|^4 times the sum
  // of |V_p|^2, half of it for mixed pairs.
  FOREFEEL_INLINE bool may_reach(const Point<Lanes>& p, const Lanes (*a)[9], const Lanes (*b)[9]) const {
    if (__builtin_isinf(reached)) return true;
    Lanes second2 = dot9(b[0], b[0]) + dot9(b[1], b[1]) + dot9(b[2], b[2]);
    second2 += 0.5 * (dot9(b[3], b[3]) + dot9(b[4], b[4]) + dot9(b[5], b[5]));
    const Lanes change = reached * (root(most_first2(a)) + reached * root(second2));
    return any_below(margin2(p), change * change);
  }
  __attribute__((noinline)) void search(const Point<Lanes>& p, const Lanes* g1, const Lanes* g2,
                                        double length) {
    if (__builtin_isinf(reached)) {  // a first distance, at which some lane is below the limit
      double t = 1.0 / 64 / __builtin_sqrt(dot9(g1, g1)[0] + 1e-300);
      for (int doubling = 0; doubling < 12; ++doubling, t *= 2)
        if (any_below(room(p, g1, g2, spread<Lanes>(t)), Lanes{})) break;
      reached = t * length;
    }
    const double t = reached / length;
    Lanes outside = spread<Lanes>(t);
    bool found = any_below(room(p, g1, g2, outside), Lanes{});
    if (!found) {
      outside = spread<Lanes>(0.5 * t);
      found = any_below(room(p, g1, g2, outside), Lanes{});
    }
    if (!found) return;
    Lanes inside{};
    const Lanes failed = room(p, g1, g2, outside);
    for (int round = 0; round < 22; ++round) {
      const Lanes middle = 0.5 * (inside + outside), value = room(p, g1, g2, middle);
      inside = value < 0.0 ? inside : middle;
      outside = value < 0.0 ? middle : outside;
    }
    for (int e = 0; e < lane_count; ++e)
      if (failed[e] < 0) reached = least(reached, outside[e] * length);
  }
  // (least stretch - limit)^2 of F, 0 below the limit and where the element is inverted. Newton from 0 stays below the
  // smallest root m of m^3 - I1 m^2 + I2 m - J^2, the square of the least stretch, so the margin is not overestimated.
  static FOREFEEL_INLINE Lanes margin2(const Point<Lanes>& p) {
    const Lanes i1 = dot9(p.f, p.f), i2 = dot9(p.cof, p.cof);
    Lanes m{};
    for (int round = 0; round < 6; ++round) {
      const Lanes slope = (3.0 * m - 2.0 * i1) * m + i2, value = ((m - i1) * m + i2) * m - p.j * p.j;
      m = slope > 0.0 ? m - value / slope : m;
    }
    const Lanes margin = root(m) - Law::least_stretch;
    const Lanes square = margin > 0.0 ? margin * margin : Lanes{};
    return p.j > 0.0 ? square : Lanes{};
  }
};

}  // namespace
}  // namespace forefeel
