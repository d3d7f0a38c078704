// Compressible neo-Hookean law: psi = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2
// (Bonet, Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, ch. 6).
#include "solver/kernels/define_law.hpp"

namespace forefeel {
namespace {

struct NeoHookean : LawDefaults {
  static constexpr const char* name = "neo-hookean";
  static constexpr bool uses_j = true, needs_positive_j = true;

  static LawConstants constants(double mu, double lambda) { return {mu, lambda, {}}; }

  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T, T j) {
    const T log_j = logarithm(j), inverse = 1.0 / j;
    Terms<T> t;
    t.psi = (0.5 * c.mu) * (i1 - 3.0) - c.mu * log_j + (0.5 * c.lambda) * log_j * log_j;
    t.d1 = spread<T>(0.5 * c.mu);
    t.dj = (c.lambda * log_j - c.mu) * inverse;
    t.djj = (c.lambda + c.mu - c.lambda * log_j) * inverse * inverse;
    return t;
  }
};

}  // namespace
}  // namespace forefeel

FOREFEEL_DEFINE_LAW(neo_hookean, NeoHookean)
