#pragma once
// How a site moves while the tip stands still at p. At fixed p the energy of a site is E(s, p - s), and
//   g = -(dE/ds + f), projected on the facet      [N]
// is the force that drives the site over the surface: the downhill slope of that energy. With one friction coefficient
// mu the site stays while |g| <= mu f . n and slides down g until equality (Harwin and Melder 2002: the friction cone
// of the proxy). Each accepted move lowers E, so sliding only dissipates. Where facets meet in a valley, E has a kink:
// the site stops on the edge, or slides along it. A tensile force, f . n < 0, has no friction: the site goes down to a
// minimum of E, or until the force pushes again. A wrong model may have E < 0, which no body has: no site goes there.
//
// g is not the tangential force: pressed straight along -n on a curved body it does not vanish.

#include "scheduling/touch/touch_field.hpp"

namespace forefeel {

enum class SlipEnd {
  sticks,    // |g| <= mu f . n, or in a valley of the surface the same along its edge
  minimum,   // of E, under a tensile force
  border,    // at a clamped facet or an open edge
  unsettled  // after the most steps allowed
};

struct Slip {
  SurfacePlace site;
  double lost = 0;  // energy that sliding dissipated [J], >= 0
  double slid = 0;  // way over the surface [m]
  SlipEnd end = SlipEnd::sticks;
  bool pulled = false;   // the force was tensile at the start
  TouchTerms terms;      // at the end; K only nearly
  double steepness = 0;  // how fast |g| - mu f . n fell along the last way [N/m]; 0: no way was gone
};

// g at (s, p - s).
Vec3 drive(const TouchField& field, const SurfacePlace& site, const TouchTerms& terms);

// friction: mu >= 0. steepness: of the last slide nearby, so that the first step is a good one; 0: not known.
Slip slide(const TouchField& field, const SurfacePlace& from, const Vec3& tip, double friction,
           double steepness = 0);

}  // namespace forefeel
