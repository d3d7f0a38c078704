// Stable neo-Hookean law: psi = m/2 (I1 - 3) + l/2 (J - a)^2 - m/2 ln(I1 + 1), counted from rest, with
// m = 4 mu/3, l = lambda + 5 mu/6, a = 1 + m/l - m/(4 l)
// (Smith, de Goes, Kim, Stable Neo-Hookean Flesh Simulation, 2018, eq. 14). Defined for J <= 0 too.
#include "solver/kernels/define_law.hpp"

namespace forefeel {
namespace {

struct StableNeoHookean : LawDefaults {
  static constexpr const char* name = "stable-neo-hookean";
  static constexpr bool uses_j = true, uses_11 = true;

  static LawConstants constants(double mu, double lambda) {
    const double m = 4 * mu / 3, l = lambda + 5 * mu / 6;
    return {mu, lambda, {m, l, 1 + m / l - m / (4 * l)}};
  }

  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T, T j) {
    const double m = c.own[0], l = c.own[1], a = c.own[2];
    const T inverse = 1.0 / (i1 + 1.0);
    const double at_rest = 0.5 * l * (1 - a) * (1 - a);
    Terms<T> t;
    // ln(I1 + 1) is counted from ln 4
    t.psi = (0.5 * m) * (i1 - 3.0) + (0.5 * l) * (j - a) * (j - a) - at_rest -
            (0.5 * m) * logarithm((i1 + 1.0) * 0.25);
    t.d1 = (0.5 * m) * (1.0 - inverse);
    t.d11 = (0.5 * m) * inverse * inverse;
    t.dj = l * (j - a);
    t.djj = spread<T>(l);
    return t;
  }
};

}  // namespace
}  // namespace forefeel

FOREFEEL_DEFINE_LAW(stable_neo_hookean, StableNeoHookean)
