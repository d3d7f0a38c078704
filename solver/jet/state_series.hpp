#pragma once
// Polynomials in three variables to degree 5,
//   p(d) = sum_{a + b + c <= 5} p_abc d_x^a d_y^b d_z^c,
// by ascending degree, within one by descending a, then b: degrees 3 to 5 are in the order of an EnergyJet.

#include <Eigen/Core>

#include "solver/jet/jet_polynomial.hpp"

namespace forefeel {

inline constexpr int series_size = 10 + static_cast<int>(jet_size);
using Series = Eigen::Matrix<double, series_size, 1>;

// 1/2 d^T K d - f . d + e and a jet's terms.
Series series_of(double e, const Vec3& f, const Mat3& k, const JetCoefficients& jet);
Series product(const Series& p, const Series& q);  // to degree 5
Series moved(const Series& p, const Vec3& x);      // p(x + d) as a polynomial in d
Series turned(const Series& p, const Mat3& t);     // p(T d)
Series inverse_growth(const Vec3& x);              // (|x| / |x + d|)^6
Series cut_after(const Series& p, int degree);     // the degrees above are zero
Mat3 stiffness_of(const Series& p);                // its second derivatives at 0

}  // namespace forefeel
