#pragma once
// The body of a scene with contact.anywhere = true, with its pad at one place.

#include <memory>
#include <string>
#include <vector>

#include "apps/scene/scene.hpp"

namespace forefeel {

// The body with its pad at the place of the surface that is nearest to `wanted` [m]; corrected by the fine body's jet
// there, if the scene has one.
struct SitedBody {
  std::shared_ptr<const Body> body;
  double clamped_share = 0;           // of the springs, carried by clamped nodes
  std::vector<std::string> warnings;  // of the pad there
};
// InputError at --site: the place is on a clamped facet, or farther from the surface than the body is long. quiet: no
// progress line.
SitedBody put_at(const Scene& scene, const Vec3& wanted, bool quiet = true);

}  // namespace forefeel
