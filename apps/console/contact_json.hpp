#pragma once
// Prints the contact of a scene: what `info SCENE` and a session's summary say of it.

#include <array>
#include <cstddef>
#include <optional>

#include "apps/console/document_keys.hpp"

namespace forefeel {

struct ContactNote {
  bool pad = false;                                       // false: rigid nodes
  std::optional<std::size_t> nodes;                       // of a rigid contact
  double radius = unknown;                                // of a pad [m]
  double stiffness = unknown;                             // of a pad, as the scene gives it [N/m]
  double area = unknown;                                  // touched surface at rest [m^2]
  double springs = unknown;                               // int a dA of a pad [N/m]
  std::array<double, 2> pulling_share{unknown, unknown};  // pressed in by 10 mm: inward, at 45 degrees to it
  double clamped_share = unknown;                         // of a pad's springs that stand on clamped nodes
};
const JsonKeys<ContactNote>& contact_keys();

}  // namespace forefeel
