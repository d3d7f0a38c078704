#include "apps/session/read_scene.hpp"

#include "apps/scene/scene.hpp"
#include "apps/scene/scene_anywhere.hpp"
#include "apps/scene/scene_session.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {

SceneInput read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const Scene scene = load_scene(file, overrides);
  if (is_anywhere(scene))
    throw InputError({.file = file.string(), .key = "contact.anywhere"},
                     "is for the command, expected one place of contact");
  return {session_input(scene), session_options(scene), scene.source.warnings};
}

}  // namespace forefeel
