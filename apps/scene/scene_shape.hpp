#pragma once
// The options of the body's shape in a scene: the keys shape_rate, shape_surface and shape_checks of [session]. Only
// sessions use them, so they are not part of Scene. load_scene() checks the keys, too; a rate above 0 makes states keep
// their displacements.

#include <filesystem>
#include <span>
#include <string>

#include "apps/scene/scene_table.hpp"
#include "scheduling/shape/shape_options.hpp"

namespace forefeel {

ShapeOptions read_shape(const SceneTable& session);
// Of a scene file with its overrides, as load_scene() takes them.
ShapeOptions load_shape(const std::filesystem::path& file, std::span<const std::string> overrides);

}  // namespace forefeel
