#include "solver/body/law.hpp"

#include <cmath>
#include <limits>

#include "solver/kernels/law_terms.hpp"

namespace forefeel {
namespace {

template <class L>
LawValue evaluate(const LawConstants& constants, const Mat3& f) {
  Point<double> point;
  for (int i = 0; i < 9; ++i) point.f[i] = f(i / 3, i % 3);
  prepare<L>(constants, point);
  LawValue value;
  value.energy = point.t.psi;
  double p[9], d[9];
  stress<L>(constants, point, p);
  for (int i = 0; i < 9; ++i) value.stress(i / 3, i % 3) = p[i];
  for (int column = 0; column < 9; ++column) {
    for (int i = 0; i < 9; ++i) d[i] = i == column;
    stress_change<L>(constants, point, d, p);
    for (int i = 0; i < 9; ++i) value.tangent(i, column) = p[i];
  }
  if (L::needs_positive_j && !(point.j > 0)) value.energy = std::numeric_limits<double>::infinity();
  return value;
}

}  // namespace

LawConstants law_constants(const Material& material) {
  const double young = material.young, poisson = material.poisson;
  LawConstants c;
  c.mu = young / (2 * (1 + poisson));
  c.lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  c.m = 4 * c.mu / 3;
  c.l = c.lambda + 5 * c.mu / 6;
  c.a = 1 + c.m / c.l - c.m / (4 * c.l);
  c.c1 = 0.35 * c.mu;
  c.c2 = 0.15 * c.mu;
  return c;
}

bool needs_positive_jacobian(Law law) {
  return law == Law::neo_hookean || law == Law::mooney_rivlin;
}

LawValue evaluate_law(Law law, const LawConstants& constants, const Mat3& f) {
  switch (law) {
    case Law::linear:
      return evaluate<Linear>(constants, f);
    case Law::st_venant_kirchhoff:
      return evaluate<StVenantKirchhoff>(constants, f);
    case Law::neo_hookean:
      return evaluate<NeoHookean>(constants, f);
    case Law::stable_neo_hookean:
      return evaluate<StableNeoHookean>(constants, f);
    case Law::mooney_rivlin:
      return evaluate<MooneyRivlin>(constants, f);
  }
  return {};
}

}  // namespace forefeel
