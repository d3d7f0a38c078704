#pragma once
// The inner loops of model evaluation (paper Eq. 1), for the three force components f_c [N] together:
//   plain    f_c(y) = p_c(y) + sum_i a_ic r^k
//   Hermite  f_c(y) = p_c(y) + sum_i [a_ic r^k - k r^(k-2) (b_ic . d)]
// y: scaled position, p_i: scaled centres, d = y - p_i, r = |d|. Compiled with -ffast-math for several
// instruction sets (instruction_set.hpp).
// n is a multiple of 8; padding has zero coefficients. data: arrays of length `stride`, one after the other:
// x y z, a_0 a_1 a_2, then (Hermite) b_00 b_01 b_02 b_10 … b_22. polynomial: 10 x 4, row t the coefficients
// of the three components over monomial t of 1 x y z xx yy zz xy xz yz, and a zero.

#include <cstddef>

namespace forefeel::sums {

// Input of an evaluation that is the sum alone: y = (x - centre) inverse_scale; the limits of |f_0|, |f_1|,
// |f_2| and |y|^2 within which the sum alone is the force.
struct Sum {
  double centre[3] = {}, inverse_scale = 1, limit[4] = {-1, -1, -1, -1};
  std::size_t n = 0, stride = 0;
  const double* data = nullptr;
  const double* polynomial = nullptr;
};
// Writes f at x. False if a limit is exceeded or a value is not a number; f is then not valid.
using Quick = bool (*)(const Sum& sum, const double x[3], double f[3]);

struct Loops {
  Quick quick[2][3];  // plain and Hermite; r, r^3, r^5
  void (*plain)(int power, std::size_t n, const double* data, std::size_t stride, const double* polynomial,
                const double y[3], double f[3]);
  void (*hermite)(int power, std::size_t n, const double* data, std::size_t stride, const double* polynomial,
                  const double y[3], double f[3]);
  // with j[3 * c + d] = df_c/dy_d
  void (*plain_jacobian)(int power, std::size_t n, const double* data, std::size_t stride,
                         const double* polynomial, const double y[3], double f[3], double j[9]);
  void (*hermite_jacobian)(int power, std::size_t n, const double* data, std::size_t stride,
                           const double* polynomial, const double y[3], double f[3], double j[9]);
  // Least and largest of axis . p_i over n >= 1 points, for 13 axes.
  void (*supports)(std::size_t n, const double* px, const double* py, const double* pz,
                   const double axes[13][3], double low[13], double high[13]);

  // Sums of x, y, z and of |p|^2 over the points with their weights (0: not counted), and the largest
  // weighted |p|^2.
  void (*extent)(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
                 double out[5]);
  // distance[i] = |p_i - y|; out: the least and the largest over the points of weight > 0.
  void (*distances)(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
                    const double y[3], double* distance, double out[2]);
  // Mean tangent (model_data.hpp): sums of w, w d, w f, w K and w K d over the points, with d = p_i - base
  // and w = weight ((farthest / distance - 1) / farthest)^2 nearest^2. data: arrays of length `stride`; f
  // from array 3 on (3), K from array 6 on (9). out: 1 + 3 + 3 + 9 + 3 values.
  void (*tangent)(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
                  const double* data, std::size_t stride, const double* distance, double nearest,
                  double farthest, const double base[3], double out[19]);
};

const Loops& loops();  // those of instruction_set_in_use()

}  // namespace forefeel::sums
