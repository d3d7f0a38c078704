#pragma once
// [hand] of a scene: the same as session.device = "hand:…", key by key.
//   [hand]
//   profile = "omega"
//   grip = "light"
//   drawn = true

#include <optional>
#include <string>

#include "apps/scene/scene_table.hpp"

namespace forefeel {

// The text of the device that the table describes; nullopt if the table has no keys. Values are checked when the text
// is read.
std::optional<std::string> device_of_hand(const SceneTable& hand);

}  // namespace forefeel
