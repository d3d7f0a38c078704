#include "apps/scene_input/scene_session.hpp"

#include <filesystem>

#include "apps/scene_input/cache_folder.hpp"

namespace forefeel {

SessionInput session_input(const Scene& scene) {
  return {.touched = {.body = scene.body,
                      .identity = scene.identity,
                      .space = scene.space,
                      .displacements = scene.displacements,
                      .inward = scene.inward},
          .files = {.cache = cache_folder(), .scene = std::filesystem::absolute(scene.file).parent_path()}};
}

}  // namespace forefeel
