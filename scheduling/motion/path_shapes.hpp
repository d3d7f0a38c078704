#pragma once
// The curves behind PathMotion (path:NAME), as polylines [m].

#include <vector>

#include "scheduling/common/factory_context.hpp"
#include "scheduling/motion/device_spec.hpp"

namespace forefeel {

struct PathShape {
  std::vector<Vec3> lead;  // from rest to the first point of the loop; starts at 0
  std::vector<Vec3> loop;  // repeated; the last point connects to the first
};

// Scaled to the box of the context; `reach` draws its targets from the seed.
PathShape path_shape(PathName path, const FactoryContext& context);

}  // namespace forefeel
