#pragma once
// Energy jet of a state: the condensed energy about its position x_0 beyond second order,
//   E(x_0 + d) = E_0 - f_0 . d + 1/2 d^T K d + sum over 3 <= a + b + c <= p + 1 of e_abc dx^a dy^b dz^c      [J]
// e_abc: coefficients, not derivatives [N/m^2, N/m^3, N/m^4 for degrees 3, 4, 5]. p, the order of the jet, is that of
// its force f = -dE/dd, whose error falls as |d|^(p + 1): p = 2, 3, 4 have degrees up to 3, 4, 5.

#include <array>
#include <cstddef>
#include <limits>
#include <string>

#include "geometry/common/types.hpp"

namespace forefeel {

inline constexpr std::size_t jet_size = 10 + 15 + 21;  // coefficients of degrees 3, 4, 5
inline constexpr int most_jet_order = 4;

struct EnergyJet {
  int order = 2;                                           // p
  double limit = std::numeric_limits<double>::infinity();  // material limit [m] (solver/jet/jet_maker.hpp)
  std::array<double, jet_size> coefficients{};  // by degree; within one a falls, then b; 0 above p + 1
};

// Position of e_abc in EnergyJet::coefficients, 3 <= a + b + c <= 5.
std::size_t jet_index(int a, int b, int c);
// "e300", "e210", … in the order of the coefficients.
const std::array<std::string, jet_size>& jet_names();
std::size_t jet_terms_of_order(int order);  // 10, 25, 46: how many coefficients a jet of this order has

// The jet's terms up to `degree` at d: energy, its gradient and its Hessian.
struct JetTerms {
  double energy = 0;             // [J]
  Vec3 gradient = Vec3::Zero();  // [N]
  Mat3 hessian = Mat3::Zero();   // [N/m]
};
JetTerms jet_terms(const EnergyJet& jet, const Vec3& d, int degree = 5);

}  // namespace forefeel
