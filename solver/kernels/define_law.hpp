#pragma once
// FOREFEEL_DEFINE_LAW(law, L): the LawEntry of the law struct L under its name in law_list.hpp, for the
// instruction set that the file is compiled for. L derives from LawDefaults (law_terms.hpp) and has
//   static constexpr const char* name                                          its word in scenes
//   static LawConstants constants(double mu, double lambda)                    from Lamé's constants [Pa]
//   template <class T> static Terms<T> terms(const LawConstants&, T i1, T i2, T j)
// psi counts from rest: psi(I) = 0. Include in law files only (see lanes.hpp).

#include "solver/kernels/jet_loops.hpp"
#include "solver/kernels/kernels.hpp"
#include "solver/kernels/law_list.hpp"

#ifndef FOREFEEL_ISA
#define FOREFEEL_ISA portable
#endif

namespace forefeel {
namespace {

// One F; LawEntry::evaluate.
template <class L>
double evaluate_one(const LawConstants& constants, const double* f, double* out, double* tangent) {
  Point<double> point;
  for (int i = 0; i < 9; ++i) point.f[i] = f[i];
  prepare<L>(constants, point);
  stress<L>(constants, point, out);
  for (int column = 0; column < 9; ++column) {
    double d[9];
    for (int i = 0; i < 9; ++i) d[i] = i == column;
    stress_change<L>(constants, point, d, tangent + 9 * column);
  }
  return L::needs_positive_j && !(point.j > 0) ? __builtin_inf() : point.t.psi;
}

template <class L>
constexpr LawEntry entry_of() {
  return {L::name,          L::form,      L::linear,       L::needs_positive_j, L::softens,
          L::least_stretch, L::constants, evaluate_one<L>, Both<L>::table,      Jets<L>::table};
}

}  // namespace
}  // namespace forefeel

#define FOREFEEL_DEFINE_LAW(law, L)                                                            \
  static_assert(static_cast<int>(forefeel::Law::law) >= 0, "the law has no line in list.hpp"); \
  namespace forefeel::FOREFEEL_ISA {                                                           \
  extern const LawEntry law;                                                                   \
  constexpr LawEntry law = entry_of<L>();                                                      \
  }
