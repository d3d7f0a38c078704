// The baseline of `evaluate hermite-r5`: compiled at -O2 without vectors, once per instruction set, as that of
// `evaluate r3` (approx/baselines/scalar_sum.cpp).
#include <cmath>
#include <cstddef>

namespace forefeel::bench::FOREFEEL_ISA {

void scalar_hermite_quintic(std::size_t n, const double* centres, const double* polynomial, const double* x,
                            double* f) {
  const double terms[10] = {1,           x[0],        x[1],        x[2],        x[0] * x[0],
                            x[1] * x[1], x[2] * x[2], x[0] * x[1], x[0] * x[2], x[1] * x[2]};
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (std::size_t t = 0; t < 10; ++t) sum += polynomial[10 * c + t] * terms[t];
    f[c] = sum;
  }
  double f0 = f[0], f1 = f[1], f2 = f[2];
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = centres + 15 * i;
    const double a = x[0] - p[0], b = x[1] - p[1], c = x[2] - p[2];
    const double r2 = a * a + b * b + c * c, r3 = r2 * std::sqrt(r2), phi = r2 * r3, slope = -5 * r3;
    f0 += p[3] * phi + slope * (p[6] * a + p[7] * b + p[8] * c);
    f1 += p[4] * phi + slope * (p[9] * a + p[10] * b + p[11] * c);
    f2 += p[5] * phi + slope * (p[12] * a + p[13] * b + p[14] * c);
  }
  f[0] = f0;
  f[1] = f1;
  f[2] = f2;
}

}  // namespace forefeel::bench::FOREFEEL_ISA
