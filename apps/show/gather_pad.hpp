#pragma once
// Where the springs of a pad act on the surface of a picture.

#include <optional>

#include "apps/show/show_content.hpp"
#include "solver/body/body.hpp"

namespace forefeel {

// The facets under the pad, split until a side is at most an eighth of the pad's radius. nullopt without a pad.
std::optional<ShownPad> shown_pad(const Body& body, const ShownBody& shown);

}  // namespace forefeel
