// Compiled at -O2 without vectors, once per instruction set.
#include <cmath>
#include <cstddef>

namespace forefeel::FOREFEEL_ISA {

void scalar_sum(std::size_t n, const double* positions, const double* coefficients, const double* x,
                double* f) {
  const double* p = coefficients + 3 * n;
  double f0 = p[0] + p[1] * x[0] + p[2] * x[1] + p[3] * x[2];
  double f1 = p[4] + p[5] * x[0] + p[6] * x[1] + p[7] * x[2];
  double f2 = p[8] + p[9] * x[0] + p[10] * x[1] + p[11] * x[2];
  for (std::size_t i = 0; i < n; ++i) {
    const double a = x[0] - positions[3 * i], b = x[1] - positions[3 * i + 1],
                 c = x[2] - positions[3 * i + 2];
    const double r2 = a * a + b * b + c * c, phi = r2 * std::sqrt(r2);
    f0 += coefficients[3 * i] * phi;
    f1 += coefficients[3 * i + 1] * phi;
    f2 += coefficients[3 * i + 2] * phi;
  }
  f[0] = f0;
  f[1] = f1;
  f[2] = f2;
}

void scalar_hermite_sum(std::size_t n, const double* centres, const double* polynomial, const double* x,
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

}  // namespace forefeel::FOREFEEL_ISA
