#pragma once
// The list of material laws. To add a law, add a file law_NAME.cpp to this folder and a line to this list; the word in
// scenes, the messages and the tests follow from them. See law_neo_hookean.cpp for a law in full.

#include "solver/kernels/kernels.hpp"

#define FOREFEEL_LAWS(LAW) \
  LAW(linear)              \
  LAW(st_venant_kirchhoff) \
  LAW(neo_hookean)         \
  LAW(stable_neo_hookean)  \
  LAW(mooney_rivlin)

namespace forefeel {

#define FOREFEEL_LAW_VALUE(law) law,
enum class Law { FOREFEEL_LAWS(FOREFEEL_LAW_VALUE) };
#undef FOREFEEL_LAW_VALUE

// What one law's file defines, once per instruction set.
struct LawEntry {
  const char* name;       // in scenes: "neo-hookean"
  bool linear;            // f = -K x exactly
  bool needs_positive_j;  // psi grows without bound as J = det F -> 0
  bool softens;           // loses stiffness in compression
  LawConstants (*constants)(double mu, double lambda);
  // psi(F) - psi(I) [J/m^3], P = dpsi/dF [Pa] and dP_ij/dF_kl at (3 i + j) + 9 (3 k + l); F and P row by row.
  double (*evaluate)(const LawConstants&, const double* f, double* stress, double* tangent);
  ElementKernels kernels;
};

}  // namespace forefeel
