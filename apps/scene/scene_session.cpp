#include "apps/scene/scene_session.hpp"

#include <filesystem>

#include "apps/scene/cache_folder.hpp"
#include "apps/scene/spec_text.hpp"

namespace forefeel {

SessionInput session_input(const Scene& scene) {
  return {.touched = {.body = scene.body,
                      .identity = scene.identity,
                      .space = scene.space,
                      .displacements = scene.kept.displacements,
                      .jet = scene.kept.jet,
                      .inward = scene.inward,
                      .viscosity = scene.touch.viscosity},
          .files = {.cache = cache_folder(),
                    .scene = std::filesystem::absolute(scene.source.file).parent_path()}};
}

SessionOptions session_options(const Scene& scene) {
  SessionOptions options = scene.session;
  options.motion.device = device_of(scene);
  options.workers.cost = cost_of(scene);
  return options;
}

DeviceSpec device_of(const Scene& scene) {
  return scene.written.device ? device_from_text(*scene.written.device) : DeviceSpec();
}

CostSpec cost_of(const Scene& scene) {
  return scene.written.cost ? cost_from_text(*scene.written.cost) : CostSpec();
}

}  // namespace forefeel
