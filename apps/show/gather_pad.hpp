#pragma once
// Where the springs of a pad act on the surface of a picture, or how stiff the body is under a pad anywhere.

#include <optional>
#include <vector>

#include "apps/scene/palpation_map.hpp"
#include "apps/show/show_content.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// The facets under the pad, split until a side is at most an eighth of the pad's radius. nullopt without a pad.
std::optional<ShownPad> shown_pad(const Body& body, const ShownBody& shown);
// The stiffness at rest of the body without the pad, at the nodes of the surface: it shows more than with it. nullopt
// where all is clamped.
std::optional<ShownPad> shown_stiffness(const std::vector<SurfaceStiffness>& map, const ShownBody& shown);
// The estimated error at this depth [m]: full colour where the force is not trusted.
std::optional<ShownPad> shown_error(const std::vector<SurfaceError>& map, double tolerance, double depth,
                                    const ShownBody& shown);

}  // namespace forefeel
