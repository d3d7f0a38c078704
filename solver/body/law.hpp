#pragma once
// The law of a material: its constants, and psi(F) with its derivatives for one deformation gradient F.
//   mu = E / (2 (1 + nu))     lambda = E nu / ((1 + nu)(1 - 2 nu))     [Pa]
// The formulas are in solver/kernels/law_*.cpp, one file per law; the element loops use the same ones.

#include <Eigen/Core>

#include "geometry/common/types.hpp"
#include "solver/body/material.hpp"
#include "solver/kernels/kernels.hpp"
#include "solver/kernels/law_list.hpp"

namespace forefeel {

using Mat9 = Eigen::Matrix<double, 9, 9>;

LawConstants law_constants(const Material& material);

// True if psi grows without bound as J = det F -> 0; J > 0 must then hold at every iterate.
bool needs_positive_jacobian(Law law);

struct LawValue {
  double energy = 0;            // psi(F) - psi(I) [J/m^3]; infinite if J <= 0 and the law needs J > 0
  Mat3 stress = Mat3::Zero();   // P = d psi / dF [Pa]
  Mat9 tangent = Mat9::Zero();  // dP_ij / dF_kl at (3 i + j, 3 k + l) [Pa]
};
// Uses the portable code: the same bits on every processor.
LawValue evaluate_law(Law law, const LawConstants& constants, const Mat3& deformation_gradient);

// The functions that the file of each material law (solver/kernels/law_*.cpp) defines.

const LawEntry& law_entry(Law law);           // as compiled for this processor
const LawEntry& portable_law_entry(Law law);  // as compiled for every processor: the same bits everywhere

}  // namespace forefeel
