#pragma once
// What a scene asks of the shape of the body: the keys shape_rate, shape_surface and shape_checks of [session].
// Only sessions want it, so it is no part of a Scene; load_scene() checks the keys too, and a rate above 0 makes
// states keep displacements.

#include <filesystem>
#include <span>
#include <string>

#include "apps/scene_input/scene_table.hpp"
#include "scheduling/shape/shape_options.hpp"

namespace forefeel {

ShapeOptions read_shape(const SceneTable& session);
// Of a scene file with its overrides, as load_scene() takes them.
ShapeOptions load_shape(const std::filesystem::path& file, std::span<const std::string> overrides);

}  // namespace forefeel
