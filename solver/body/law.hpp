#pragma once
// Hyperelastic laws. F deformation gradient, J = det F, C = F^T F, I1 = tr C, I2 = (I1^2 - tr C^2)/2,
// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu)(1 - 2 nu)). Energy density psi [J/m^3]:
//   linear               lambda/2 tr(e)^2 + mu e:e,  e = sym(F) - I
//   St. Venant-Kirchhoff lambda/2 tr(G)^2 + mu G:G,  G = (C - I)/2
//   neo-Hookean          mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2
//   stable neo-Hookean   m/2 (I1 - 3) + l/2 (J - a)^2 - m/2 ln(I1 + 1), m = 4 mu/3, l = lambda + 5 mu/6,
//                        a = 1 + m/l - m/(4 l)          (Smith, de Goes, Kim 2018, eq. 14)
//   Mooney-Rivlin        c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + lambda/2 (ln J)^2, c1 = 0.35 mu, c2 = 0.15 mu
// Every psi here is counted from rest: psi(I) = 0. The formulas themselves live once, in law_terms.hpp, written for
// one number or for eight side by side; the functions below evaluate them for one F.

#include <Eigen/Core>

#include "solver/body/body.hpp"
#include "solver/kernels/kernels.hpp"

namespace forefeel {

using Mat9 = Eigen::Matrix<double, 9, 9>;

LawConstants law_constants(const Material& material);

// True where psi grows without bound as J -> 0, so that J > 0 must hold at every iterate.
bool needs_positive_jacobian(Law law);

struct LawValue {
  double energy = 0;            // psi(F) - psi(I) [J/m^3]; infinite where J <= 0 and the law needs J > 0
  Mat3 stress = Mat3::Zero();   // P = d psi / dF [Pa]
  Mat9 tangent = Mat9::Zero();  // dP_ij / dF_kl at (3 i + j, 3 k + l) [Pa]
};
LawValue evaluate_law(Law law, const LawConstants& constants, const Mat3& deformation_gradient);

}  // namespace forefeel
