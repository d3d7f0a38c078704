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

}  // namespace forefeel::FOREFEEL_ISA
