#include "approx/kernel_sums.hpp"

#include <cmath>

#include "geometry/simd.hpp"

#define FOREFEEL_INLINE static inline __attribute__((always_inline))

namespace forefeel::sums {
namespace {

template <int K>
FOREFEEL_INLINE double power_of(double r2, double r) {
  if constexpr (K == -1) return 1 / (r > 1e-100 ? r : 1e-100);
  if constexpr (K == 0) return 1;
  if constexpr (K == 1) return r;
  if constexpr (K == 3) return r * r2;
  if constexpr (K == 5) return r * r2 * r2;
}

template <int K>
FOREFEEL_INLINE void plain_of(std::size_t n, const double* data, std::size_t stride, const double* y,
                              double* f) {
  const double* __restrict px = data;
  const double* __restrict py = data + stride;
  const double* __restrict pz = data + 2 * stride;
  const double* __restrict a0 = data + 3 * stride;
  const double* __restrict a1 = data + 4 * stride;
  const double* __restrict a2 = data + 5 * stride;
  const double y0 = y[0], y1 = y[1], y2 = y[2];
  double s0 = 0, s1 = 0, s2 = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = y0 - px[i], dy = y1 - py[i], dz = y2 - pz[i];
    const double r2 = dx * dx + dy * dy + dz * dz;
    const double phi = power_of<K>(r2, std::sqrt(r2));
    s0 += a0[i] * phi;
    s1 += a1[i] * phi;
    s2 += a2[i] * phi;
  }
  f[0] += s0;
  f[1] += s1;
  f[2] += s2;
}

template <int K>
FOREFEEL_INLINE void plain_jacobian_of(std::size_t n, const double* data, std::size_t stride, const double* y,
                                       double* f, double* j) {
  const double* __restrict px = data;
  const double* __restrict py = data + stride;
  const double* __restrict pz = data + 2 * stride;
  const double* __restrict a0 = data + 3 * stride;
  const double* __restrict a1 = data + 4 * stride;
  const double* __restrict a2 = data + 5 * stride;
  const double y0 = y[0], y1 = y[1], y2 = y[2];
  double s0 = 0, s1 = 0, s2 = 0, j00 = 0, j01 = 0, j02 = 0, j10 = 0, j11 = 0, j12 = 0, j20 = 0, j21 = 0,
         j22 = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = y0 - px[i], dy = y1 - py[i], dz = y2 - pz[i];
    const double r2 = dx * dx + dy * dy + dz * dz;
    const double r = std::sqrt(r2);
    const double phi = power_of<K>(r2, r), slope = K * power_of<K - 2>(r2, r);
    s0 += a0[i] * phi;
    s1 += a1[i] * phi;
    s2 += a2[i] * phi;
    const double w0 = a0[i] * slope, w1 = a1[i] * slope, w2 = a2[i] * slope;
    j00 += w0 * dx;
    j01 += w0 * dy;
    j02 += w0 * dz;
    j10 += w1 * dx;
    j11 += w1 * dy;
    j12 += w1 * dz;
    j20 += w2 * dx;
    j21 += w2 * dy;
    j22 += w2 * dz;
  }
  f[0] += s0;
  f[1] += s1;
  f[2] += s2;
  const double sum[9] = {j00, j01, j02, j10, j11, j12, j20, j21, j22};
  for (int t = 0; t < 9; ++t) j[t] += sum[t];
}

template <int K>
FOREFEEL_INLINE void hermite_of(std::size_t n, const double* data, std::size_t stride, const double* y,
                                double* f) {
  const double* __restrict px = data;
  const double* __restrict py = data + stride;
  const double* __restrict pz = data + 2 * stride;
  const double* __restrict a = data + 3 * stride;
  const double* __restrict b = data + 6 * stride;
  const double y0 = y[0], y1 = y[1], y2 = y[2];
  double s0 = 0, s1 = 0, s2 = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = y0 - px[i], dy = y1 - py[i], dz = y2 - pz[i];
    const double r2 = dx * dx + dy * dy + dz * dz;
    const double r = std::sqrt(r2);
    const double low = power_of<K - 2>(r2, r);  // phi = low r^2
    s0 += low * (a[i] * r2 - K * (b[i] * dx + b[stride + i] * dy + b[2 * stride + i] * dz));
    s1 += low * (a[stride + i] * r2 -
                 K * (b[3 * stride + i] * dx + b[4 * stride + i] * dy + b[5 * stride + i] * dz));
    s2 += low * (a[2 * stride + i] * r2 -
                 K * (b[6 * stride + i] * dx + b[7 * stride + i] * dy + b[8 * stride + i] * dz));
  }
  f[0] += s0;
  f[1] += s1;
  f[2] += s2;
}

template <int K>
FOREFEEL_INLINE void hermite_jacobian_of(std::size_t n, const double* data, std::size_t stride,
                                         const double* y, double* f, double* j) {
  const double* __restrict px = data;
  const double* __restrict py = data + stride;
  const double* __restrict pz = data + 2 * stride;
  for (int c = 0; c < 3; ++c) {
    const double* __restrict a = data + (3 + c) * stride;
    const double* __restrict bx = data + (6 + 3 * c) * stride;
    const double* __restrict by = bx + stride;
    const double* __restrict bz = by + stride;
    const double y0 = y[0], y1 = y[1], y2 = y[2];
    double s = 0, jx = 0, jy = 0, jz = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double dx = y0 - px[i], dy = y1 - py[i], dz = y2 - pz[i];
      const double r2 = dx * dx + dy * dy + dz * dz;
      const double r = std::sqrt(r2);
      const double low = power_of<K - 2>(r2, r);
      const double along = bx[i] * dx + by[i] * dy + bz[i] * dz;
      s += low * (a[i] * r2 - K * along);
      const double radial = K * (a[i] * low - (K - 2) * power_of<K - 4>(r2, r) * along);
      jx += radial * dx - K * low * bx[i];
      jy += radial * dy - K * low * by[i];
      jz += radial * dz - K * low * bz[i];
    }
    f[c] += s;
    j[3 * c] += jx;
    j[3 * c + 1] += jy;
    j[3 * c + 2] += jz;
  }
}

}  // namespace

FOREFEEL_CLONES void plain(int power, std::size_t n, const double* data, std::size_t stride,
                           const double y[3], double f[3]) {
  n &= ~std::size_t{7};
  if (power == 1) return plain_of<1>(n, data, stride, y, f);
  if (power == 3) return plain_of<3>(n, data, stride, y, f);
  plain_of<5>(n, data, stride, y, f);
}

FOREFEEL_CLONES void hermite(int power, std::size_t n, const double* data, std::size_t stride,
                             const double y[3], double f[3]) {
  n &= ~std::size_t{7};
  if (power == 3) return hermite_of<3>(n, data, stride, y, f);
  hermite_of<5>(n, data, stride, y, f);
}

FOREFEEL_CLONES void plain_jacobian(int power, std::size_t n, const double* data, std::size_t stride,
                                    const double y[3], double f[3], double j[9]) {
  n &= ~std::size_t{7};
  if (power == 1) return plain_jacobian_of<1>(n, data, stride, y, f, j);
  if (power == 3) return plain_jacobian_of<3>(n, data, stride, y, f, j);
  plain_jacobian_of<5>(n, data, stride, y, f, j);
}

FOREFEEL_CLONES void hermite_jacobian(int power, std::size_t n, const double* data, std::size_t stride,
                                      const double y[3], double f[3], double j[9]) {
  n &= ~std::size_t{7};
  if (power == 3) return hermite_jacobian_of<3>(n, data, stride, y, f, j);
  hermite_jacobian_of<5>(n, data, stride, y, f, j);
}

FOREFEEL_CLONES void supports(std::size_t n, const double* px, const double* py, const double* pz,
                              const double axes[13][3], double low[13], double high[13]) {
  const double* __restrict x = px;
  const double* __restrict y = py;
  const double* __restrict z = pz;
  for (int k = 0; k < 13; ++k) {
    const double a = axes[k][0], b = axes[k][1], c = axes[k][2];
    double least = 1e300, most = -1e300;
    for (std::size_t i = 0; i < n; ++i) {
      const double along = a * x[i] + b * y[i] + c * z[i];
      least = along < least ? along : least;
      most = along > most ? along : most;
    }
    low[k] = least;
    high[k] = most;
  }
}

}  // namespace forefeel::sums
