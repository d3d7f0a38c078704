// Linear elasticity: psi = lambda/2 tr(e)^2 + mu e:e, e = sym(F) - I. Not a function of the invariants, so
// energy, stress and the stress's change are written out.
#include "solver/kernels/define_law.hpp"

namespace forefeel {
namespace {

struct Linear : LawDefaults {
  static constexpr const char* name = "linear";
  static constexpr bool linear = true, of_invariants = false;
  static constexpr double least_stretch = 0;  // its jets are exact

  static LawConstants constants(double mu, double lambda) { return {mu, lambda, {}}; }
  template <class T>
  static FOREFEEL_INLINE T energy(const LawConstants& c, const T* f) {
    const T e0 = f[0] - 1.0, e1 = f[4] - 1.0, e2 = f[8] - 1.0, trace = e0 + e1 + e2;
    const T s0 = f[1] + f[3], s1 = f[2] + f[6], s2 = f[5] + f[7];
    return (0.5 * c.lambda) * trace * trace + c.mu * (e0 * e0 + e1 * e1 + e2 * e2) +
           (0.5 * c.mu) * (s0 * s0 + s1 * s1 + s2 * s2);
  }
  template <class T>
  static FOREFEEL_INLINE void stress(const LawConstants& c, const T* f, T* out) {
    const T pressure = c.lambda * ((f[0] - 1.0) + (f[4] - 1.0) + (f[8] - 1.0));
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        out[3 * i + k] =
            i == k ? (2 * c.mu) * (f[4 * i] - 1.0) + pressure : c.mu * (f[3 * i + k] + f[3 * k + i]);
      }
  }
  template <class T>
  static FOREFEEL_INLINE void stress_change(const LawConstants& c, const T* d, T* out) {
    const T pressure = c.lambda * (d[0] + d[4] + d[8]);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        out[3 * i + k] = c.mu * (d[3 * i + k] + d[3 * k + i]);
        if (i == k) out[3 * i + k] += pressure;
      }
  }
};

}  // namespace
}  // namespace forefeel

FOREFEEL_DEFINE_LAW(linear, Linear)
