#pragma once
// The data that a session passes to the factory of a part (policy, predictor, device, cost model).

#include <cstdint>
#include <filesystem>

#include "geometry/common/types.hpp"
#include "scheduling/common/arguments.hpp"

namespace forefeel {

class TouchSurface;  // motion/touch_surface.hpp

struct FactoryContext {
  Box box = {};                  // where states are placed [m]
  Vec3 inward = -Vec3::UnitZ();  // from the contact into the body
  std::uint64_t seed = 0;        // of the session: the only source of random numbers
  // Folder of the scene. Relative files are looked up here, then in the working directory.
  std::filesystem::path folder = {};
  const TouchSurface* surface =
      nullptr;               // of a body that may be touched anywhere: motions are in the axes of the mesh
  Arguments arguments = {};  // the user's settings; empty for built-in parts
};

}  // namespace forefeel
