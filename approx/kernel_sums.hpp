#pragma once
// The inner loops of model evaluation (paper Eq. 1), three force components together, in one translation unit
// with -ffast-math and for several instruction sets. n is a multiple of 8; padding carries zero coefficients.
// Plain: f_c += sum_i a_ic r^k. Hermite: f_c += sum_i a_ic r^k - k r^(k-2) (b_ic . d), d = y - p_i.
// data: arrays of length stride one after the other: x y z, a_0 a_1 a_2, then (Hermite) b_00 b_01 b_02 b_10 …
// b_22.

#include <cstddef>

namespace forefeel::sums {

void plain(int power, std::size_t n, const double* data, std::size_t stride, const double y[3], double f[3]);
void hermite(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
             double f[3]);
// with j[3 * c + d] += df_c/dy_d
void plain_jacobian(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
                    double f[3], double j[9]);
void hermite_jacobian(int power, std::size_t n, const double* data, std::size_t stride, const double y[3],
                      double f[3], double j[9]);

// Least and largest of axis . p_i over n >= 1 points, for 13 axes.
void supports(std::size_t n, const double* px, const double* py, const double* pz, const double axes[13][3],
              double low[13], double high[13]);

}  // namespace forefeel::sums
