// St. Venant-Kirchhoff law: psi = lambda/2 tr(G)^2 + mu G:G with Green's strain G = (C - I)/2;
// tr G = (I1 - 3)/2 and G:G = (I1^2 - 2 I2 - 2 I1 + 3)/4. Softens in compression and has no resistance to J
// -> 0.
#include "solver/kernels/define_law.hpp"

namespace forefeel {
namespace {

struct StVenantKirchhoff : LawDefaults {
  static constexpr const char* name = "st-venant-kirchhoff";
  static constexpr bool uses_i2 = true, uses_11 = true, softens = true;
  static constexpr double least_stretch = 0.57735026918962576;  // 1 / sqrt(3): uniaxial stress peaks there

  static LawConstants constants(double mu, double lambda) { return {mu, lambda, {}}; }

  template <class T>
  static FOREFEEL_INLINE Terms<T> terms(const LawConstants& c, T i1, T i2, T) {
    const T g = i1 - 3.0;
    Terms<T> t;
    t.psi = (0.125 * c.lambda) * g * g + (0.25 * c.mu) * (i1 * i1 - 2.0 * i2 - 2.0 * i1 + 3.0);
    t.d1 = (0.25 * c.lambda) * g + (0.5 * c.mu) * (i1 - 1.0);
    t.d2 = spread<T>(-0.5 * c.mu);
    t.d11 = spread<T>(0.25 * c.lambda + 0.5 * c.mu);
    return t;
  }
};

}  // namespace
}  // namespace forefeel

FOREFEEL_DEFINE_LAW(st_venant_kirchhoff, StVenantKirchhoff)
