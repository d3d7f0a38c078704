#include "apps/scene/scene_shape.hpp"

#include "apps/scene/scene_declared.hpp"

namespace forefeel {

ShapeOptions read_shape(const SceneTable& session) {
  ShapeOptions shape;
  shape.rate =
      session.number("shape_rate", {.low = 0, .high = 200, .text = "from 0 to 200 Hz"}).value_or(shape.rate);
  shape.surface = session.boolean("shape_surface").value_or(shape.surface);
  shape.checks = static_cast<std::size_t>(
      session.integer("shape_checks", 0, 10'000).value_or(static_cast<std::int64_t>(shape.checks)));
  return shape;
}

ShapeOptions load_shape(const std::filesystem::path& file, std::span<const std::string> overrides) {
  const SceneDocument document = SceneDocument::read(file, overrides);
  return read_shape(document.root(keys_of("")).sub("session", keys_of("session")));
}

}  // namespace forefeel
