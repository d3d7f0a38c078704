// Sums over states at sites, compiled once per instruction set: see site_sums.hpp.
#include "solver/kernels/site_sums.hpp"

#include "solver/kernels/element_lanes.hpp"

#ifndef FOREFEEL_ISA
#define FOREFEEL_ISA portable
#endif

namespace forefeel {
namespace {

struct Three {
  Lanes x, y, z;
};
FOREFEEL_INLINE Three all(const double* v) {
  return {spread<Lanes>(v[0]), spread<Lanes>(v[1]), spread<Lanes>(v[2])};
}
FOREFEEL_INLINE Three operator+(const Three& a, const Three& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
FOREFEEL_INLINE Three operator-(const Three& a, const Three& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
FOREFEEL_INLINE Three operator*(const Lanes& s, const Three& v) {
  return {s * v.x, s * v.y, s * v.z};
}
FOREFEEL_INLINE Lanes dot(const Three& a, const Three& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
FOREFEEL_INLINE Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Symmetric {
  Lanes xx, xy, xz, yy, yz, zz;
};
FOREFEEL_INLINE Three operator*(const Symmetric& m, const Three& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
FOREFEEL_INLINE Symmetric operator+(const Symmetric& a, const Symmetric& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
FOREFEEL_INLINE Symmetric operator*(const Lanes& s, const Symmetric& m) {
  return {s * m.xx, s * m.xy, s * m.xz, s * m.yy, s * m.yz, s * m.zz};
}
// a b^T + b a^T.
FOREFEEL_INLINE Symmetric both_ways(const Three& a, const Three& b) {
  return {2.0 * a.x * b.x, a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x,
          2.0 * a.y * b.y, a.y * b.z + a.z * b.y, 2.0 * a.z * b.z};
}

// The least turn Q that takes n to m, v = n x m (solver/jet/site_turns.hpp); of: Q u, back: Q^T p, by_normal: the
// derivative of p . Q u by n.
struct Turn {
  Three m, v;
  Lanes over;
  FOREFEEL_INLINE Three of(const Three& u) const {
    const Three once = cross(v, u);
    return u + once + over * cross(v, once);
  }
  FOREFEEL_INLINE Three back(const Three& p) const {
    const Three once = cross(v, p);
    return p - once + over * cross(v, once);
  }
  FOREFEEL_INLINE Three by_normal(const Three& p, const Three& u) const {
    const Three once = cross(v, u);
    const Three by_v = cross(u, p) + over * (cross(once, p) + cross(u, cross(p, v)));
    return cross(m, by_v) - over * over * dot(p, cross(v, once)) * m;
  }
  // Q^T H Q.
  FOREFEEL_INLINE Symmetric back(const Symmetric& h) const {
    const Lanes one = spread<Lanes>(1), none = spread<Lanes>(0);
    const Three x = of({one, none, none}), y = of({none, one, none}), z = of({none, none, one});
    const Three hx = h * x, hy = h * y, hz = h * z;
    return {dot(x, hx), dot(x, hy), dot(x, hz), dot(y, hy), dot(y, hz), dot(z, hz)};
  }
};

constexpr int place_of(int a, int b, int c) {
  const int n = a + b + c, left = b + c;
  return n * (n + 1) * (n + 2) / 6 + left * (left + 1) / 2 + c;
}

struct Smooth {
  Lanes value;
  Three slope;
  Symmetric bend;
};
// A polynomial to degree 5 with its derivatives, by Horner's rule in z, y and x.
template <bool bend>
FOREFEEL_INLINE Smooth polynomial(const Lanes* p, const Three& d) {
  const Lanes none = spread<Lanes>(0);
  Smooth f{none, {none, none, none}, {none, none, none, none, none, none}};
#pragma GCC unroll 8
  for (int a = 5; a >= 0; --a) {
    Lanes g = none, gy = none, gz = none, gyy = none, gyz = none, gzz = none;
#pragma GCC unroll 8
    for (int b = 5 - a; b >= 0; --b) {
      Lanes h = none, hz = none, hzz = none;
#pragma GCC unroll 8
      for (int c = 5 - a - b; c >= 0; --c) {
        if (bend) hzz = hzz * d.z + 2.0 * hz;
        hz = hz * d.z + h;
        h = h * d.z + p[place_of(a, b, c)];
      }
      if (bend) gyy = gyy * d.y + 2.0 * gy, gyz = gyz * d.y + gz, gzz = gzz * d.y + hzz;
      gy = gy * d.y + g;
      gz = gz * d.y + hz;
      g = g * d.y + h;
    }
    if (bend) {
      f.bend.xx = f.bend.xx * d.x + 2.0 * f.slope.x;
      f.bend.xy = f.bend.xy * d.x + f.slope.y, f.bend.xz = f.bend.xz * d.x + f.slope.z;
      f.bend.yy = f.bend.yy * d.x + gyy, f.bend.yz = f.bend.yz * d.x + gyz, f.bend.zz = f.bend.zz * d.x + gzz;
    }
    f.slope.x = f.slope.x * d.x + f.value;
    f.slope.y = f.slope.y * d.x + gy, f.slope.z = f.slope.z * d.x + gz;
    f.value = f.value * d.x + g;
  }
  return f;
}

// x[i] of eight vectors becomes lane i of eight others.
FOREFEEL_INLINE void transpose(Lanes x[8]) {
  Lanes y[8];
  for (int i = 0; i < 8; i += 2) {
    y[i] = __builtin_shufflevector(x[i], x[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    y[i + 1] = __builtin_shufflevector(x[i], x[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int i = 0; i < 8; i += (i & 1) ? 3 : 1) {
    x[i] = __builtin_shufflevector(y[i], y[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    x[i + 2] = __builtin_shufflevector(y[i], y[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (int i = 0; i < 4; ++i) {
    y[i] = __builtin_shufflevector(x[i], x[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    y[i + 4] = __builtin_shufflevector(x[i], x[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
  for (int i = 0; i < 8; ++i) x[i] = y[i];
}

constexpr int head = 24;  // numbers of a row before its polynomial
static_assert(sizeof(SiteRow) == sizeof(double) * (head + series_terms));

// Eight rows as lanes.
struct Rows {
  Lanes number[head + series_terms];
  FOREFEEL_INLINE void read(const SiteRow* const* rows) {
#pragma GCC unroll 1
    for (int first = 0; first < head + series_terms; first += 8) {
      for (int i = 0; i < 8; ++i) number[first + i] = load(rows[i]->at + first);
      transpose(number + first);
    }
  }
  FOREFEEL_INLINE Three three(int first) const {
    return {number[first], number[first + 1], number[first + 2]};
  }
};

// The sums of eight lanes each.
struct Accumulated {
  Lanes weight, value, square;
  Three weight_u, weight_n, weight_s, value_u, value_n, value_s, slope;
  Symmetric weight_bend, value_bend;
};

// The distance along the surface over which a state fades, from 0 to 1, for it and its slope.
FOREFEEL_INLINE Lanes kept_between(const Lanes& t) {
  const Lanes none = spread<Lanes>(0), one = spread<Lanes>(1);
  const Lanes low = t < none ? none : t;
  return low < one ? low : one;
}

// way: three times eight. count: lanes that stand for a state.
template <bool bend>
FOREFEEL_INLINE void add(const SiteRow* const* rows, const double* ways, int count, const SiteQuestion& asked,
                         Accumulated& sum) {
  Rows r;
  r.read(rows);
  const Lanes none = spread<Lanes>(0), one = spread<Lanes>(1);
  const Three n = all(asked.normal), u = all(asked.u), m = r.three(3);
  const Three away = all(asked.at) - r.three(0), leant = n - m;
  const Symmetric metric{r.number[9], r.number[10], r.number[11], r.number[12], r.number[13], r.number[14]};
  const Lanes near = r.number[15], growing = r.number[16], reach = r.number[17];

  const Turn turn{m, cross(n, m), one / (one + dot(n, m))};
  const Three z = turn.of(u), d = z - r.three(6), bent = metric * d;
  const Lanes q = (dot(away, away) + asked.square * dot(leant, leant)) * reach + near * dot(d, bent);
  const Three way{load(ways), load(ways + 8), load(ways + 16)};
  const Lanes t = kept_between((dot(all(asked.share), way) - asked.far) / asked.far);
  const Lanes number{0, 1, 2, 3, 4, 5, 6, 7};
  const Lanes kept = one - t * t * t * (10.0 + t * (6.0 * t - 15.0));
  const Lanes cut = q < one ? (number < spread<Lanes>(count) ? kept : none) : none;
  const Lanes cut_slope =
      q < one ? (number < spread<Lanes>(count) ? t * t * (one - t) * (one - t) : none) : none;

  // (1 - q)^3 / q^2
  const Lanes left = one - q, over = one / (q * q + site_softening), core = left * left * left * over;
  const Lanes core_slope = (-3.0 * left * left - 2.0 * q * core) * over;
  const Three by_z = 2.0 * near * bent, q_u = turn.back(by_z);
  const Lanes weight = cut * core, by_q = cut * core_slope;
  const Three weight_u = by_q * q_u;
  const Three weight_n = 2.0 * by_q * asked.square * reach * leant + by_q * turn.by_normal(by_z, u);
  const Three ahead =
      way.x * all(asked.share_by) + way.y * all(asked.share_by + 3) + way.z * all(asked.share_by + 6);
  const Three weight_s = 2.0 * by_q * reach * away - (30.0 / asked.far) * core * cut_slope * ahead;

  // C = (z^T M z / |x_k|^2)^3 P; of a jet at rest P alone.
  const Smooth p = polynomial<bend>(r.number + head, d);
  const Three by = 2.0 * growing * (metric * z);
  const Lanes ratio = 0.5 * dot(z, by), g = ratio * ratio * ratio + (growing > none ? none : one);
  const Three g_z = 3.0 * ratio * ratio * by;
  const Lanes value = g * p.value;
  const Three value_z = g * p.slope + p.value * g_z, value_u = turn.back(value_z);

  sum.weight += weight, sum.weight_u = sum.weight_u + weight_u;
  sum.weight_n = sum.weight_n + weight_n, sum.weight_s = sum.weight_s + weight_s;
  sum.value += weight * value;
  sum.slope = sum.slope + weight * value_u;
  sum.value_u = sum.value_u + weight * value_u + value * weight_u;
  sum.value_n = sum.value_n + weight * turn.by_normal(value_z, u) + value * weight_n;
  sum.value_s = sum.value_s + value * weight_s;
  const Three force{dot(all(asked.root), value_u), dot(all(asked.root + 3), value_u),
                    dot(all(asked.root + 6), value_u)};
  sum.square += weight * dot(force, force);
  if (!bend) return;
  const Lanes core_bend = (6.0 * left - 2.0 * core - 4.0 * q * core_slope) * over;
  const Symmetric weight_bend =
      0.5 * cut * core_bend * both_ways(q_u, q_u) + 2.0 * near * by_q * turn.back(metric);
  const Symmetric g_bend = 6.0 * ratio * (ratio * growing * metric + spread<Lanes>(0.5) * both_ways(by, by));
  const Symmetric value_bend = turn.back(g * p.bend + p.value * g_bend + both_ways(g_z, p.slope));
  sum.weight_bend = sum.weight_bend + weight_bend;
  sum.value_bend = sum.value_bend + weight * value_bend + value * weight_bend + both_ways(weight_u, value_u);
}

FOREFEEL_INLINE double total(const Lanes& x) {
  return ((x[0] + x[4]) + (x[1] + x[5])) + ((x[2] + x[6]) + (x[3] + x[7]));
}
FOREFEEL_INLINE void add_to(double* out, const Three& x) {
  out[0] += total(x.x), out[1] += total(x.y), out[2] += total(x.z);
}
FOREFEEL_INLINE void add_to(double* out, const Symmetric& x) {
  out[0] += total(x.xx), out[1] += total(x.xy), out[2] += total(x.xz);
  out[3] += total(x.yy), out[4] += total(x.yz), out[5] += total(x.zz);
}

template <bool bend>
void site_sums(const SitePack* pack, const SiteQuestion& asked, SiteSums& out) {
  const Three at = all(asked.at), normal = all(asked.normal), share = all(asked.share);
  const Lanes one = spread<Lanes>(1);
  const SiteRow* rows[8];
  alignas(64) double ways[24] = {};
  Accumulated sum{};
  int waiting = 0;
  bool any = false;
  for (; pack != nullptr; pack = pack->next) {
    const Three away = at - Three{load(pack->at[0]), load(pack->at[1]), load(pack->at[2])},
                leant = normal - Three{load(pack->normal[0]), load(pack->normal[1]), load(pack->normal[2])};
    const Lanes q = (dot(away, away) + asked.square * dot(leant, leant)) * load(pack->reach),
                way = dot(share, {load(pack->way[0]), load(pack->way[1]), load(pack->way[2])});
    const LaneBits seen = (q < one) & (way < spread<Lanes>(2 * asked.far));
    for (int i = 0; i < 8; ++i) {
      if (seen[i] == 0) continue;
      rows[waiting] = pack->row[i];
      for (int corner = 0; corner < 3; ++corner) ways[8 * corner + waiting] = pack->way[corner][i];
      if (++waiting < 8) continue;
      add<bend>(rows, ways, 8, asked, sum);
      waiting = 0, any = true;
    }
  }
  if (waiting > 0) {
    for (int i = waiting; i < 8; ++i) rows[i] = rows[0];
    add<bend>(rows, ways, waiting, asked, sum);
    any = true;
  }
  if (!any) return;
  out.weights.value += total(sum.weight), out.values.value += total(sum.value),
      out.square += total(sum.square);
  add_to(out.weights.by_u, sum.weight_u), add_to(out.values.by_u, sum.value_u);
  add_to(out.weights.by_normal, sum.weight_n), add_to(out.values.by_normal, sum.value_n);
  add_to(out.weights.by_site, sum.weight_s), add_to(out.values.by_site, sum.value_s);
  add_to(out.slope, sum.slope);
  if (bend) add_to(out.weights.bend, sum.weight_bend), add_to(out.values.bend, sum.value_bend);
}

}  // namespace

namespace FOREFEEL_ISA {
extern const SiteKernels site_kernels;
const SiteKernels site_kernels{site_sums<false>, site_sums<true>};
}  // namespace FOREFEEL_ISA
}  // namespace forefeel
