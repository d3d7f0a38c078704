#pragma once
// An isotropic material: its law (solver/kernels/law_*.cpp) and the two elastic constants at rest.

#include "solver/body/law_table.hpp"

namespace forefeel {

struct Material {
  Law law = Law::neo_hookean;
  double young = 5000;    // E [Pa], > 0
  double poisson = 0.45;  // nu, in (-1, 0.5)
  friend bool operator==(const Material&, const Material&) = default;
};

}  // namespace forefeel
