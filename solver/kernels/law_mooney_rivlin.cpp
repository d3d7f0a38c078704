// Mooney-Rivlin law: psi = c1 (I1 - 3 - 2 ln J) + c2 (I2 - 3 - 4 (J - 1)) + lambda/2 (ln J)^2, with
// c1 = 0.35 mu and c2 = 0.15 mu (so that 2 (c1 + c2) = mu). At rest its constants are mu and lambda exactly: the second
// derivatives of I2 and of 4 J cancel there but for 2 c2 of shear. All terms are at least 0 for every F with J > 0.
#include "solver/kernels/define_law.hpp"

namespace forefeel {
namespace {

struct MooneyRivlin : LawDefaults {
  static constexpr const char* name = "mooney-rivlin";
  static constexpr const char* form = "4 (J - 1) beside I2: exact mu and lambda at rest";
  static constexpr bool uses_i2 = true, uses_j = true, needs_positive_j = true;

  static LawConstants constants(double mu, double lambda) { return {mu, lambda, {0.35 * mu, 0.15 * mu}}; }

  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T i2, T j) {
    const double c1 = c.own[0], c2 = c.own[1];
    const T log_j = logarithm(j), inverse = 1.0 / j;
    Terms<T> t;
    t.psi =
        c1 * (i1 - 3.0 - 2.0 * log_j) + c2 * (i2 - 3.0 - 4.0 * (j - 1.0)) + (0.5 * c.lambda) * log_j * log_j;
    t.d1 = spread<T>(c1);
    t.d2 = spread<T>(c2);
    t.dj = (c.lambda * log_j - 2 * c1) * inverse - 4 * c2;
    t.djj = (c.lambda + 2 * c1 - c.lambda * log_j) * inverse * inverse;
    return t;
  }
};

}  // namespace
}  // namespace forefeel

FOREFEEL_DEFINE_LAW(mooney_rivlin, MooneyRivlin)
