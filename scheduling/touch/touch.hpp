#pragma once
// Touching a body anywhere. Inside and outside mean the body at rest, of the smooth surface over its facets
// (solver/jet/smooth_surface.hpp). The tip outside feels nothing. Where it crosses the surface a touch begins: the
// site s on it, and x = tip - s. Without friction the site stays; with it the site slides (below). The touch ends when
// the tip is outside again, or when a tensile force finds a minimum of E before it becomes a push. Crossing a clamped
// facet begins none. A tip inside from the start begins at the nearest place. One point, one coefficient, no torque.
//
// E of the sites is a potential and sliding lowers it, so over a closed path the hand gets back no more than it gave.

#include <optional>

#include "scheduling/common/records.hpp"
#include "scheduling/touch/touch_field.hpp"

namespace forefeel {

// How a site moves while the tip stands still at p. At fixed p the energy of a site is E(s, p - s), and
//   g = -(dE/ds + f), projected on the tangent plane of the smooth surface      [N]
// is the force that drives the site over the surface: the downhill slope of that energy. With one friction coefficient
// mu the site stays while |g| <= mu f . n and slides down g until equality (Harwin and Melder 2002: the friction cone
// of the proxy). Each accepted move lowers E, so sliding only dissipates. At an edge that is kept, a rim of the body,
// E may have a kink: the site stops on the edge, or slides along it. A tensile force, f . n < 0, has no friction: the
// site goes down to a minimum of E, or until the force pushes again. A wrong model may have E < 0, which no body has:
// no site goes there.
//
// g is not the tangential force: pressed straight along -n on a curved body it does not vanish.

// Where E has a fold, equality is far: the body itself snaps. There a frame goes only a part of the way, as the damped
// switch does with a change of models: until the force has changed by the switch's bound, or by half as much again as
// the motion of the tip changes it where that is more, or the site has gone three times the tip's way. The next frames
// go on. Behind a fast tip the force changes by more although the body has no fold; that is not held up: the slide is
// followed in parts of the tip's way, and is at its end if the site is so with the last.

enum class SlipEnd {
  sticks,    // |g| <= mu f . n, or at a kept edge the same along it
  minimum,   // of E, under a tensile force
  border,    // at a clamped facet or an open edge
  limited,   // by SlideLimit
  unsettled  // after the most steps allowed
};

// Of one frame.
struct SlideLimit {
  Vec3 before = Vec3::Zero();  // force of the frame before [N]
  double change = 0;           // most |f - before|, if the start of the slide is within it [N]
  double way = 0;              // most way over the surface [m]
};

struct Slip {
  SurfacePlace site;
  Vec3 held = Vec3::Zero();  // force at the start, before the site slides [N]
  double lost = 0;           // energy that sliding dissipated [J], >= 0
  double slid = 0;           // way over the surface [m]
  SlipEnd end = SlipEnd::sticks;
  bool pulled = false;   // the force was tensile at the start
  TouchTerms terms;      // at the end; K only nearly
  double steepness = 0;  // how fast |g| - mu f . n fell along the last way [N/m]; 0: no way was gone
};

Vec3 drive(const TouchTerms& terms);  // g

// friction: mu >= 0. steepness: of the last slide nearby, so that the first step is a good one; 0: not known.
Slip slide(const TouchField& field, const SurfacePlace& from, const Vec3& tip, double friction,
           double steepness = 0, const std::optional<SlideLimit>& limit = {});

struct Touch {
  TouchKind kind = TouchKind::none;
  SurfacePlace site;          // valid unless none
  Vec3 tip = Vec3::Zero();    // [m]
  bool known = false;         // false before the first tip
  bool inside = false;        // the tip, of the body at rest
  Vec3 force = Vec3::Zero();  // of the body on the tip [N]
  double steepness = 0;       // of the last slide; only the way to the answer depends on it
};

struct TouchFrame {
  Touch touch;                        // after the tip has moved
  Vec3 force = Vec3::Zero();          // of the body on the tip [N]
  Vec3 normal = Vec3::Zero();         // mean normal under the pad
  Vec3 drive = Vec3::Zero();          // g of the slide [N]
  double energy = 0;                  // stored [J]
  double tip_change = 0;              // of the force by the tip's way, at the site of the frame before [N]
  double lost = 0;                    // by sliding, and at the end of a touch [J]
  bool at_border = false;             // the slide ended at a clamped facet
  bool snaps = false;                 // the slide was limited
  std::optional<SurfacePlace> began;  // the place where a touch began
  std::optional<Vec3> left;           // where on its way the tip left the body, and a touch ended [m]
};

// friction: mu >= 0; none: the site sticks.
TouchFrame touch(const TouchField& field, const Touch& before, const Vec3& tip,
                 std::optional<double> friction);

}  // namespace forefeel
