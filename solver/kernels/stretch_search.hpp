#pragma once
// The material limit of an energy jet (solver/jet/jet_maker.hpp): how far the jet's own displacement can go before an
// element's least principal stretch falls below the limit of its law. Include in kernel files only (element_lanes.hpp).

#include "solver/kernels/element_loops.hpp"
#include "solver/kernels/forms.hpp"

namespace forefeel {
namespace {

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
FOREFEEL_INLINE void along_way(const double* x, MatrixForm<1> a, MatrixForm<2> b, Lanes* g1, Lanes* g2) {
  double product[6];
  for (int p = 0; p < 6; ++p) product[p] = x[upper_row[p]] * x[upper_column[p]];
  for (int i = 0; i < 9; ++i) {
    g1[i] = x[0] * a[i][0] + x[1] * a[i][1] + x[2] * a[i][2];
    g2[i] = Lanes{};
    for (int p = 0; b && p < 6; ++p) g2[i] += product[p] * b[i][p];
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
  // room2: (least stretch - limit)^2 of F. A change of F by less cannot reach the limit.
  FOREFEEL_INLINE void visit(const Point<Lanes>& p, const Lanes* g1, const Lanes* g2, Lanes room2,
                             double length) {
    const Lanes first2 = dot9(g1, g1), second2 = dot9(g2, g2), product = dot9(g1, g2);
    const Lanes cross = 2.0 * (product < 0.0 ? -product : product);
    const auto changes = [&](double t) {  // |t G_1 + t^2 G_2|, for d or for its opposite
      return any_below(room2, (t * t) * (first2 + t * (cross + t * second2)));
    };
    const bool unknown = __builtin_isinf(reached);
    if (!unknown && !changes(reached / length)) return;
    search(p, g1, g2, length, unknown || changes(0.5 * reached / length));
    Lanes opposite[9];
    for (int i = 0; i < 9; ++i) opposite[i] = -g1[i];
    search(p, opposite, g2, length, unknown || changes(0.5 * reached / length));
  }
  // All directions. b: null where V is 0.
  __attribute__((noinline)) void all(const Point<Lanes>& p, const JetDirections& directions, MatrixForm<1> a,
                                     MatrixForm<2> b) {
    const Lanes room2 = margin2(p);
    for (int k = 0; k < directions.count; ++k) {
      Lanes g1[9], g2[9];
      along_way(directions.ways + 3 * k, a, b, g1, g2);
      visit(p, g1, g2, room2, directions.lengths[k]);
    }
  }
  // |G_1|^2 along any d is at most this times |d|^2: Gershgorin's bound of the Gram matrix of the columns of grad U.
  static FOREFEEL_INLINE Lanes most_first2(MatrixForm<1> a) {
    Lanes gram[6]{};
    add_contraction<1, 1>(a, a, gram);  // twice the entries beside the diagonal
    const auto row = [&](int on, int first, int second) {
      const auto size = [&](int p) { return gram[p] < 0.0 ? -gram[p] : gram[p]; };
      return gram[on] + 0.5 * (size(first) + size(second));
    };
    const Lanes x = row(0, 1, 2), y = row(3, 1, 4), z = row(5, 2, 4), two = x > y ? x : y;
    return two > z ? two : z;
  }
  static FOREFEEL_INLINE Lanes hardness(const Point<Lanes>& p, MatrixForm<1> a) {
    const Lanes room2 = margin2(p);
    return most_first2(a) / (room2 > 1e-300 ? room2 : spread<Lanes>(1e-300));
  }
  // True if some direction may reach the limit within the least distance known. |G_2|^2 is at most |d|^4 times the sum
  // of |V_p|^2, half of it for mixed pairs.
  FOREFEEL_INLINE bool may_reach(const Point<Lanes>& p, MatrixForm<1> a, MatrixForm<2> b) const {
    if (__builtin_isinf(reached)) return true;
    Lanes on{}, beside{};
    for (int i = 0; b && i < 9; ++i) {
      on += b[i][0] * b[i][0] + b[i][3] * b[i][3] + b[i][5] * b[i][5];
      beside += b[i][1] * b[i][1] + b[i][2] * b[i][2] + b[i][4] * b[i][4];
    }
    const Lanes change = reached * (root(most_first2(a)) + reached * root(on + 0.5 * beside));
    return any_below(margin2(p), change * change);
  }
  // half: whether the limit may be reached half-way, too.
  __attribute__((noinline)) void search(const Point<Lanes>& p, const Lanes* g1, const Lanes* g2,
                                        double length, bool half) {
    if (__builtin_isinf(reached)) {  // a first distance, at which some lane is below the limit
      double t = 1.0 / 64 / __builtin_sqrt(dot9(g1, g1)[0] + 1e-300);
      for (int doubling = 0; doubling < 12; ++doubling, t *= 2)
        if (any_below(room(p, g1, g2, spread<Lanes>(t)), Lanes{})) break;
      reached = t * length;
    }
    const double t = reached / length;
    Lanes outside = spread<Lanes>(t);
    bool found = any_below(room(p, g1, g2, outside), Lanes{});
    if (!found && half) {
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
  // (least stretch - limit)^2 of F, 0 below the limit and where the element is inverted. The squares of the stretches
  // are the roots of m^3 - I1 m^2 + I2 m - J^2; the smallest is not below their mean less 2/3 sqrt(I1^2 - 3 I2), and is
  // just that where the other two are equal.
  static FOREFEEL_INLINE Lanes margin2(const Point<Lanes>& p) {
    const Lanes i1 = dot9(p.f, p.f), apart = i1 * i1 - 3.0 * dot9(p.cof, p.cof);
    const Lanes least_root = (1.0 / 3) * i1 - (2.0 / 3) * root(apart > 0.0 ? apart : Lanes{});
    const Lanes m = least_root > 0.0 ? least_root : Lanes{};
    const Lanes margin = root(m) - Law::least_stretch;
    const Lanes square = margin > 0.0 ? margin * margin : Lanes{};
    return p.j > 0.0 ? square : Lanes{};
  }
};

}  // namespace
}  // namespace forefeel
