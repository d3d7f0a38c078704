#pragma once
// Reads [session].

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_table.hpp"

namespace forefeel {

// Everything but the device of [hand]. Device and cost stay texts (scene_session.hpp).
void read_session(const SceneTable& session, Scene& scene);

}  // namespace forefeel
