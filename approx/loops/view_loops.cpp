// Compiled once per instruction set.
#include "approx/loops/view_loops.hpp"

#include "approx/loops/lanes.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

std::size_t seen(std::size_t n, const double* x, const double* y, const double* z, const double* distance,
                 const double v[3], double cosine, double scale, double depth, double* seen,
                 double* nearest) {
  constexpr std::size_t block = 32;
  const Pack a = same(v[0]), b = same(v[1]), c = same(v[2]), from = same(cosine), steep = same(scale),
             none = {};
  Pack least = same(1e300);
  *nearest = 1e300;
  std::size_t i = 0;
  while (i < n && !(distance[i] > *nearest + depth)) {
    for (const std::size_t end = n - i < block ? n : i + block; i < end; i += width) {
      const Pack along = times_plus(load(x + i), a, times_plus(load(y + i), b, load(z + i) * c));
      const Pack apart = from - along, off = apart > none ? apart : none;
      const Pack far = times_plus(off * off, steep, load(distance + i));
      store(seen + i, far);
      least = far < least ? far : least;
    }
    *nearest = least[0];
    for (std::size_t t = 1; t < width; ++t) *nearest = least[t] < *nearest ? least[t] : *nearest;
  }
  return i;
}

void towards(std::size_t n, const double* x, const double* y, const double* z, const double* seen,
             double nearest, double depth, double out[3]) {
  const Pack slope = same(-1 / depth), at = same(1 + nearest / depth), none = {};
  Pack sum[3] = {};
  for (std::size_t i = 0; i < n; i += width) {
    const Pack near = times_plus(load(seen + i), slope, at), positive = near > none ? near : none,
               w = positive * positive;
    sum[0] = times_plus(w, load(x + i), sum[0]);
    sum[1] = times_plus(w, load(y + i), sum[1]);
    sum[2] = times_plus(w, load(z + i), sum[2]);
  }
  for (int d = 0; d < 3; ++d) out[d] = sum_of(sum[d]);
}

}  // namespace

extern const view::Loops view_loops;
const view::Loops view_loops = {seen, towards};

}  // namespace forefeel::FOREFEEL_ISA
