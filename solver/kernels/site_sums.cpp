// Sums over states at sites, compiled once per instruction set: see site_sums.hpp.
#include "solver/kernels/site_sums.hpp"

#include "geometry/common/simd.hpp"

#ifndef FOREFEEL_ISA
#define FOREFEEL_ISA portable
#endif

namespace forefeel {
namespace {

// As many states at a time as a register holds: with more of them the sums do not fit in the registers.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
using Wide = double __attribute__((vector_size(8 * width)));
using WideBits = long long __attribute__((vector_size(8 * width)));

FOREFEEL_INLINE Wide same(double value) {
  return value - Wide{};
}
FOREFEEL_INLINE Wide load_wide(const double* p) {
  Wide v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

struct Three {
  Wide x, y, z;
};
FOREFEEL_INLINE Three all(const double* v) {
  return {same(v[0]), same(v[1]), same(v[2])};
}
FOREFEEL_INLINE Three operator+(const Three& a, const Three& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
FOREFEEL_INLINE Three operator-(const Three& a, const Three& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
FOREFEEL_INLINE Three operator*(const Wide& s, const Three& v) {
  return {s * v.x, s * v.y, s * v.z};
}
FOREFEEL_INLINE Wide dot(const Three& a, const Three& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
FOREFEEL_INLINE Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Symmetric {
  Wide xx, xy, xz, yy, yz, zz;
};
FOREFEEL_INLINE Three operator*(const Symmetric& m, const Three& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
FOREFEEL_INLINE Symmetric operator+(const Symmetric& a, const Symmetric& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
FOREFEEL_INLINE Symmetric operator*(const Wide& s, const Symmetric& m) {
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
  Wide over;
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
    const Wide one = same(1), none = same(0);
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
  Wide value;
  Three slope;
  Symmetric bend;
};
// A polynomial to degree 5 with its derivatives, by Horner's rule in z, y and x.
template <bool bend>
FOREFEEL_INLINE Smooth polynomial(const Wide* p, const Three& d) {
  const Wide none = same(0);
  Smooth f{none, {none, none, none}, {none, none, none, none, none, none}};
#pragma GCC unroll 8
  for (int a = 5; a >= 0; --a) {
    Wide g = none, gy = none, gz = none, gyy = none, gyz = none, gzz = none;
#pragma GCC unroll 8
    for (int b = 5 - a; b >= 0; --b) {
      Wide h = none, hz = none, hzz = none;
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

#if defined(__AVX512F__)
// x[i] of eight vectors becomes lane i of eight others.
FOREFEEL_INLINE void transpose(Wide x[8]) {
  Wide y[8];
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
#endif

constexpr int head = 24;  // numbers of a row before its polynomial
static_assert(sizeof(SiteRow) == sizeof(double) * (head + series_terms));

// Rows side by side.
struct Rows {
  Wide number[head + series_terms];
  FOREFEEL_INLINE void read(const SiteRow* const* rows) {
#if defined(__AVX512F__)
#pragma GCC unroll 1
    for (int first = 0; first < head + series_terms; first += 8) {
      for (int i = 0; i < 8; ++i)
        number[first + i] = load_wide(reinterpret_cast<const double*>(rows[i]) + first);
      transpose(number + first);
    }
#else  // there, permuting takes longer than moving each number
    for (int i = 0; i < width; ++i) {
      const double* row = reinterpret_cast<const double*>(rows[i]);
      for (int k = 0; k < head + series_terms; ++k) number[k][i] = row[k];
    }
#endif
  }
  FOREFEEL_INLINE Three three(int first) const {
    return {number[first], number[first + 1], number[first + 2]};
  }
};

// Sums, in as many parts.
struct Accumulated {
  Wide weight, value, square;
  Three weight_u, weight_n, weight_s, value_u, value_n, value_s, slope;
  Symmetric weight_bend, value_bend;
};

// The distance along the surface over which a state fades, from 0 to 1, for it and its slope.
FOREFEEL_INLINE Wide kept_between(const Wide& t) {
  const Wide none = same(0), one = same(1);
  const Wide low = t < none ? none : t;
  return low < one ? low : one;
}

// ways: of the three corners. count: how many of the rows stand for a state.
template <bool bend>
FOREFEEL_INLINE void add(const SiteRow* const* rows, const double* ways, int count, const SiteQuestion& asked,
                         Accumulated& sum) {
  Rows r;
  r.read(rows);
  const Wide none = same(0), one = same(1);
  const Three n = all(asked.normal), u = all(asked.u), m = r.three(3);
  const Three away = all(asked.at) - r.three(0), leant = n - m;
  const Symmetric metric{r.number[9], r.number[10], r.number[11], r.number[12], r.number[13], r.number[14]};
  const Wide near = r.number[15], growing = r.number[16], reach = r.number[17];

  const Turn turn{m, cross(n, m), one / (one + dot(n, m))};
  const Three z = turn.of(u), d = z - r.three(6), bent = metric * d;
  const Wide q = (dot(away, away) + asked.square * dot(leant, leant)) * reach + near * dot(d, bent);
  const Three way{load_wide(ways), load_wide(ways + width), load_wide(ways + 2 * width)};
  const Wide t = kept_between((dot(all(asked.share), way) - asked.far) / asked.far);
  Wide number{};
  for (int i = 0; i < width; ++i) number[i] = i;
  const Wide kept = one - t * t * t * (10.0 + t * (6.0 * t - 15.0));
  const Wide cut = q < one ? (number < same(count) ? kept : none) : none;
  const Wide cut_slope = q < one ? (number < same(count) ? t * t * (one - t) * (one - t) : none) : none;

  // (1 - q)^3 / q^2
  const Wide left = one - q, over = one / (q * q + site_softening), core = left * left * left * over;
  const Wide core_slope = (-3.0 * left * left - 2.0 * q * core) * over;
  const Three by_z = 2.0 * near * bent, q_u = turn.back(by_z);
  const Wide weight = cut * core, by_q = cut * core_slope;
  const Three weight_u = by_q * q_u;
  const Three weight_n = 2.0 * by_q * asked.square * reach * leant + by_q * turn.by_normal(by_z, u);
  const Three ahead =
      way.x * all(asked.share_by) + way.y * all(asked.share_by + 3) + way.z * all(asked.share_by + 6);
  const Three weight_s = 2.0 * by_q * reach * away - (30.0 / asked.far) * core * cut_slope * ahead;

  // C = (z^T M z / |x_k|^2)^3 P; of a jet at rest P alone.
  const Smooth p = polynomial<bend>(r.number + head, d);
  const Three by = 2.0 * growing * (metric * z);
  const Wide ratio = 0.5 * dot(z, by), g = ratio * ratio * ratio + (growing > none ? none : one);
  const Three g_z = 3.0 * ratio * ratio * by;
  const Wide value = g * p.value;
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
  const Wide core_bend = (6.0 * left - 2.0 * core - 4.0 * q * core_slope) * over;
  const Symmetric weight_bend =
      0.5 * cut * core_bend * both_ways(q_u, q_u) + 2.0 * near * by_q * turn.back(metric);
  const Symmetric g_bend = 6.0 * ratio * (ratio * growing * metric + same(0.5) * both_ways(by, by));
  const Symmetric value_bend = turn.back(g * p.bend + p.value * g_bend + both_ways(g_z, p.slope));
  sum.weight_bend = sum.weight_bend + weight_bend;
  sum.value_bend = sum.value_bend + weight * value_bend + value * weight_bend + both_ways(weight_u, value_u);
}

FOREFEEL_INLINE double total(const Wide& x) {
  double sum = 0;
  for (int i = 0; i < width; ++i) sum += x[i];
  return sum;
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
  const Wide one = same(1);
  const SiteRow* rows[width];
  alignas(64) double ways[3 * width] = {};
  Accumulated sum{};
  int waiting = 0;
  bool any = false;
  for (; pack != nullptr; pack = pack->next)
    for (int first = 0; first < lane_count; first += width) {
      const auto part = [&](const double* of) __attribute__((always_inline)) {
        return load_wide(of + first);
      };
      const Three away = at - Three{part(pack->at[0]), part(pack->at[1]), part(pack->at[2])},
                  leant = normal - Three{part(pack->normal[0]), part(pack->normal[1]), part(pack->normal[2])};
      const Wide q = (dot(away, away) + asked.square * dot(leant, leant)) * part(pack->reach),
                 way = dot(share, {part(pack->way[0]), part(pack->way[1]), part(pack->way[2])});
      const WideBits seen = (q < one) & (way < same(2 * asked.far));
      for (int i = 0; i < width; ++i) {
        if (seen[i] == 0) continue;
        rows[waiting] = pack->row[first + i];
        for (int corner = 0; corner < 3; ++corner)
          ways[width * corner + waiting] = pack->way[corner][first + i];
        if (++waiting < width) continue;
        add<bend>(rows, ways, width, asked, sum);
        waiting = 0, any = true;
      }
    }
  if (waiting > 0) {
    for (int i = waiting; i < width; ++i) rows[i] = rows[0];
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

void place_sums(const double* const* row, const double (*weight)[4], int count, double (*out)[place_terms]) {
  for (int first = 0; first < place_terms; first += width) {
    const int at = first + width <= place_terms ? first : place_terms - width;  // the last ones again
    Wide sum[4] = {};
    for (int k = 0; k < count; ++k) {
      const Wide part = load_wide(row[k] + at);
      for (int j = 0; j < 4; ++j) sum[j] += weight[k][j] * part;
    }
    for (int j = 0; j < 4; ++j) __builtin_memcpy(out[j] + at, &sum[j], sizeof(Wide));
  }
}

}  // namespace

namespace FOREFEEL_ISA {
extern const SiteKernels site_kernels;
const SiteKernels site_kernels{site_sums<false>, site_sums<true>, place_sums};
}  // namespace FOREFEEL_ISA
}  // namespace forefeel
