#pragma once
// Prints the contact of a scene: what `info SCENE` and a session's summary say of it.

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "apps/console/document_keys.hpp"
#include "geometry/common/types.hpp"

namespace forefeel {

struct ContactNote {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  bool pad = false;                                 // false: rigid nodes
  std::optional<std::size_t> nodes;                 // of a rigid contact
  double radius = none;                             // of a pad [m]
  double stiffness = none;                          // of a pad, as the scene gives it [N/m]
  double area = none;                               // touched surface at rest [m^2]
  double springs = none;                            // int a dA of a pad [N/m]
  std::array<double, 2> pulling_share{none, none};  // pressed in by 10 mm: inward, at 45 degrees to it
  double clamped_share = none;                      // of a pad's springs that stand on clamped nodes
  std::optional<std::array<Vec3, 2>> place =
      {};  // where the tip rests [m], and the mean outward normal there
};
const JsonKeys<ContactNote>& contact_keys();

}  // namespace forefeel
