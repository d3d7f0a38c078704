#pragma once
// Rate-dependent tissue: the relaxation function of a generalised Maxwell material, and the recursive filter that
// turns a rendered elastic force into a viscoelastic one.
//   G(t) = 1 - sum g_i (1 - exp(-t / tau_i))             relaxation function, G(0) = 1        [1]
//   F(t) = integral over s <= t of G(t - s) dF_e(s)      quasi-linear viscoelasticity         [N]
// F_e [N]: elastic force at the position of the tip, g_i: share [1], tau_i: relaxation time [s], F [N]: rendered
// force. The elastic law of the scene is the instantaneous one: a fast press gives F_e; if the tip is held, the force
// falls to the long-term value (1 - sum g_i) F_e. (Fung, Biomechanics, 2nd ed. 1993, ch. 7.)
//
// The filter is exact if F_e is linear within each step dt (Taylor, Pister and Goudreau 1970; Simo and Hughes,
// Computational Inelasticity, 1998, ch. 10):
//   h_i <- exp(-dt / tau_i) h_i + g_i (1 - exp(-dt / tau_i)) / (dt / tau_i) (F_e - F_e before)
//   F = (1 - sum g_i) F_e + sum h_i
// h_i [N]: force in branch i; "F_e before": F_e of the previous step. dt [s] may differ from step to step. The body
// counts as undeformed before the first step; if the tip starts pressed in, the press happens in that step.
//
// Accuracy. Filtering the force is equivalent to a viscoelastic body if the law is linear, shear and bulk relax by
// the same function in the whole body, and the contact nodes never change (here they do not). Then it differs from a
// time-stepped finite-element solve by 5e-9 of the largest force (tests/scheduling/test_viscosity.cpp). Otherwise it
// is an approximation. On beams with shares 0.3 and 0.25 the error reaches 14 % of the largest force if only shear
// relaxes, and 0.2 to 1.6 % in neo-Hookean presses by 2 to 12 mm at hand speed (test_viscosity_nonlinear.cpp).
//
// Propagation of errors. The filter is linear. If F_e has an error, the error of F at any time is at most
// (1 + sum g_i) times the largest error of F_e so far. A sudden change dF of F_e in a step changes F in that step by
// at most |dF|, so the bounds of the force switch per frame also hold after the filter.

#include <string>
#include <vector>

#include "geometry/common/types.hpp"

namespace forefeel {

struct MaxwellBranch {
  double share = 0;  // g_i, in (0, 1)
  double time = 0;   // tau_i, > 0 [s]
  friend bool operator==(const MaxwellBranch&, const MaxwellBranch&) = default;
};
using Viscosity = std::vector<MaxwellBranch>;  // empty: elastic

// Describes the first invalid value, as "…, expected …"; empty if all are valid.
std::string problem_of(const Viscosity& viscosity);
double long_term_share(const Viscosity& viscosity);       // 1 - sum g_i
double relaxation(const Viscosity& viscosity, double t);  // G(t), t >= 0 [s]

class RelaxationFilter {
 public:
  explicit RelaxationFilter(const Viscosity& viscosity);

  // elastic: F_e now [N]; dt: time since the previous step [s], ignored in the first step. Returns F [N]. A force that
  // is not finite is returned unchanged and does not enter the filter; the next step then covers the time of both.
  // Allocates and throws nothing.
  Vec3 step(const Vec3& elastic, double dt) noexcept;

 private:
  struct Branch {
    double share, time, decay, weight;  // the last two for dt_
    Vec3 stress;                        // h_i [N]
  };
  std::vector<Branch> branches_;
  double long_term_, dt_ = -1, passed_ = 0;
  Vec3 last_ = Vec3::Zero();
  bool begun_ = false;
};

}  // namespace forefeel
