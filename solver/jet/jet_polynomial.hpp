#pragma once
// Degrees 3 to 5 of an energy as a polynomial in other variables (coefficients in the order of EnergyJet):
//   substituted(e, T): e'(z) = e(T z) for every z
//   monomials(z): all z_x^a z_y^b z_z^c, 3 <= a + b + c <= 5, with gradients and Hessians
// so a sum of polynomials is a dot product of coefficients and monomials.

#include <Eigen/Core>

#include "geometry/states/energy_jet.hpp"

namespace forefeel {

using JetCoefficients = Eigen::Matrix<double, static_cast<int>(jet_size), 1>;
using JetGradient = Eigen::Matrix<double, static_cast<int>(jet_size), 3>;

JetCoefficients coefficients_of(const EnergyJet& jet);
JetCoefficients substituted(const JetCoefficients& e, const Mat3& t);

struct JetMonomials {
  JetCoefficients value;
  JetGradient gradient;
  Eigen::Matrix<double, static_cast<int>(jet_size), 6> hessian;  // xx, yy, zz, xy, xz, yz
};
JetMonomials jet_monomials(const Vec3& z);

// The sum of coefficients and monomials to this degree: energy, gradient, Hessian.
JetTerms jet_sum(const JetCoefficients& e, const JetMonomials& at, int degree = 5);

// Of 1/2 d^T K d and a jet's terms: the distance at which, in the root mean square over directions, some degree of the
// force reaches twice |K d| [m]; infinite without such degrees. Near a fold the series says nothing farther away.
double series_radius(const Mat3& k, const JetCoefficients& jet);

}  // namespace forefeel
