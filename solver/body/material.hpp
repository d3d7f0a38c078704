#pragma once
// An isotropic material: its law (solver/kernels/law_*.cpp) and the two elastic constants at rest.

#include <string_view>
#include <vector>

#include "solver/kernels/law_list.hpp"

namespace forefeel {

std::string_view name(Law law);  // "neo-hookean", …
std::string_view form(Law law);  // that this version computes, where older ones had another; else ""
std::vector<Law> all_laws();     // in the order of solver/kernels/law_list.hpp

struct Material {
  Law law = Law::neo_hookean;
  // Of every law: its stiffness at rest is that of the linear law with the same two.
  double young = 5000;    // E [Pa], > 0
  double poisson = 0.45;  // nu, in (-1, 0.5)
  friend bool operator==(const Material&, const Material&) = default;
};

// Accepted range of Young's modulus. Outside it, forces leave the range in which residuals can be judged, and a value
// in the wrong unit is the likely cause. (The limits are far beyond any foam and a thousand times diamond.)

inline constexpr double softest_young = 1e-3, stiffest_young = 1e15;  // E [Pa]

}  // namespace forefeel
