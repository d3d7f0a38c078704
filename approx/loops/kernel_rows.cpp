// Compiled once per instruction set.
#include "approx/loops/kernel_rows.hpp"

#include "geometry/common/simd.hpp"

namespace forefeel::FOREFEEL_ISA {
namespace {

template <int K>
FOREFEEL_INLINE void values_of(std::size_t n, const double* __restrict px, const double* __restrict py,
                               const double* __restrict pz, const double* a, double* __restrict out) {
  const double ax = a[0], ay = a[1], az = a[2];
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = ax - px[i], dy = ay - py[i], dz = az - pz[i];
    const double r2 = dx * dx + dy * dy + dz * dz;
    const double r = __builtin_sqrt(r2);
    out[i] = K == 1 ? r : K == 3 ? r * r2 : r * r2 * r2;
  }
}

template <int K>
FOREFEEL_INLINE void hermite_of(std::size_t n, const double* __restrict px, const double* __restrict py,
                                const double* __restrict pz, const double* a, double* __restrict out,
                                std::size_t stride) {
  double* __restrict o0 = out;
  double* __restrict o1 = out + stride;
  double* __restrict o2 = out + 2 * stride;
  double* __restrict o3 = out + 3 * stride;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = a[0] - px[i], dy = a[1] - py[i], dz = a[2] - pz[i];
    const double r2 = dx * dx + dy * dy + dz * dz;
    const double r = __builtin_sqrt(r2);
    const double first = K == 3 ? 3 * r : 5 * r * r2;                       // k r^(k-2)
    const double second = K == 3 ? 3 / (r > 1e-150 ? r : 1e-150) : 15 * r;  // k (k-2) r^(k-4)
    o0[4 * i] = K == 3 ? r * r2 : r * r2 * r2;
    o0[4 * i + 1] = -first * dx;
    o0[4 * i + 2] = -first * dy;
    o0[4 * i + 3] = -first * dz;
    o1[4 * i] = first * dx;
    o1[4 * i + 1] = -first - second * dx * dx;
    o1[4 * i + 2] = -second * dx * dy;
    o1[4 * i + 3] = -second * dx * dz;
    o2[4 * i] = first * dy;
    o2[4 * i + 1] = -second * dx * dy;
    o2[4 * i + 2] = -first - second * dy * dy;
    o2[4 * i + 3] = -second * dy * dz;
    o3[4 * i] = first * dz;
    o3[4 * i + 1] = -second * dx * dz;
    o3[4 * i + 2] = -second * dy * dz;
    o3[4 * i + 3] = -first - second * dz * dz;
  }
}

template <std::size_t Q>
FOREFEEL_INLINE void project_of(std::size_t m, const double* __restrict l, const double* __restrict v,
                                std::size_t stride, const double* la, const double* va,
                                const double* __restrict weight, double* __restrict out) {
  for (std::size_t i = 0; i < m; ++i) {
    double sum = out[i];
    for (std::size_t j = 0; j < Q; ++j) sum -= la[j] * v[j * stride + i] + va[j] * l[j * stride + i];
    out[i] = weight[i] * sum;
  }
}

void values(int power, std::size_t n, const double* px, const double* py, const double* pz, const double a[3],
            double* out) {
  if (power == 1) return values_of<1>(n, px, py, pz, a, out);
  if (power == 3) return values_of<3>(n, px, py, pz, a, out);
  values_of<5>(n, px, py, pz, a, out);
}

void hermite(int power, std::size_t n, const double* px, const double* py, const double* pz,
             const double a[3], double* out, std::size_t stride) {
  if (power == 3) return hermite_of<3>(n, px, py, pz, a, out, stride);
  hermite_of<5>(n, px, py, pz, a, out, stride);
}

void project(std::size_t q, std::size_t m, const double* l, const double* v, std::size_t stride,
             const double* la, const double* va, const double* weight, double* out) {
  if (q == 1) return project_of<1>(m, l, v, stride, la, va, weight, out);
  if (q == 4) return project_of<4>(m, l, v, stride, la, va, weight, out);
  project_of<10>(m, l, v, stride, la, va, weight, out);
}

}  // namespace

extern const rows::Loops row_loops;
const rows::Loops row_loops = {values, hermite, project};

}  // namespace forefeel::FOREFEEL_ISA
