#pragma once
// Rate-dependent tissue: the relaxation function of a generalised Maxwell material, and the exact recursive filter
// that a rendered elastic force passes.
//   G(t) = 1 - sum g_i (1 - exp(-t / tau_i))             relaxation function, G(0) = 1        [1]
//   F(t) = integral over s <= t of G(t - s) dF_e(s)      quasi-linear viscoelasticity         [N]
// F_e [N]: the elastic force at the tip's position, g_i: share [1], tau_i: time [s]. The elastic law of the scene is
// thus the INSTANTANEOUS one: a fast press feels F_e, a held one falls to the long-term force (1 - sum g_i) F_e.
// Fung, Biomechanics (2nd ed. 1993), eq. 7.6:1.
//
// The filter is exact for F_e linear within each step dt (Taylor, Pister and Goudreau 1970; Simo and Hughes,
// Computational Inelasticity, 1998, eqs. 10.3.12 to 10.3.16):
//   h_i <- exp(-dt / tau_i) h_i + g_i (1 - exp(-dt / tau_i)) / (dt / tau_i) (F_e - F_e before)
//   F = (1 - sum g_i) F_e + sum h_i
// dt [s] may differ from step to step. The body is undeformed before the first step: a body that is met pressed in
// was pressed at that moment.
//
// Where the filter of the force equals the viscoelastic body: a linear law, one relaxation function for shear and
// bulk in the whole body, and a contact that never changes (ours does not): 5e-9 of the largest force away from a
// time-stepped finite-element solve (tests/scheduling/test_viscosity.cpp). Elsewhere it is an approximation. Where
// only shear relaxes it is up to 14 % of the largest force wrong for the beam of that test (nu = 0.3, shares 0.3 and
// 0.25). For laws that are not linear the gap has not been measured.
//
// What the filter does to errors: it is linear, and |F - F'| at any time is at most (1 + sum g_i) times the largest
// |F_e - F_e'| so far. A change of F_e in one step changes F by no more: bounds on |dF| per frame hold after it.

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

// What is wrong with it, as "…, expected …"; empty if nothing is.
std::string problem_of(const Viscosity& viscosity);
double long_term_share(const Viscosity& viscosity);       // 1 - sum g_i
double relaxation(const Viscosity& viscosity, double t);  // G(t), t >= 0 [s]

class RelaxationFilter {
 public:
  explicit RelaxationFilter(const Viscosity& viscosity);

  // elastic: F_e [N], now; dt: since the step before [s], no effect in the first step. Returns F [N]. A force that
  // is not finite is returned as it is and forgotten: the next step takes the place of both. Allocates and throws
  // nothing.
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
