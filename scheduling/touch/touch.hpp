#pragma once
// Touching a body anywhere. Inside and outside mean the body at rest. The tip outside feels nothing. Where it crosses
// the surface a touch begins: the site s, and x = tip - s. Without friction the site stays; with it the site slides
// (slip.hpp). The touch ends when the tip is outside again, or when a tensile force finds a minimum of E before it
// becomes a push. Crossing a clamped facet begins none. A tip inside from the start begins at the nearest place. One
// point, one coefficient, no torque.
//
// E of the sites is a potential and sliding lowers it, so over a closed path the hand gets back no more than it gave.

#include <optional>

#include "scheduling/common/records.hpp"
#include "scheduling/touch/slip.hpp"

namespace forefeel {

struct Touch {
  TouchKind kind = TouchKind::none;
  SurfacePlace site;        // valid unless none
  Vec3 tip = Vec3::Zero();  // [m]
  bool known = false;       // false before the first tip
  bool inside = false;      // the tip, of the body at rest
  double steepness = 0;     // of the last slide (slip.hpp); only the way to the answer depends on it
};

struct TouchFrame {
  Touch touch;                        // after the tip has moved
  Vec3 force = Vec3::Zero();          // of the body on the tip [N]
  Vec3 normal = Vec3::Zero();         // mean normal under the pad
  Vec3 drive = Vec3::Zero();          // g of slip.hpp [N]
  double energy = 0;                  // stored [J]
  double lost = 0;                    // by sliding, and at the end of a touch [J]
  bool at_border = false;             // the slide ended at a clamped facet
  std::optional<SurfacePlace> began;  // the place where a touch began
  std::optional<Vec3> left;           // where on its way the tip left the body, and a touch ended [m]
};

// friction: mu >= 0; none: the site sticks.
TouchFrame touch(const TouchField& field, const Touch& before, const Vec3& tip,
                 std::optional<double> friction);

}  // namespace forefeel
