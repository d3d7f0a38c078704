#pragma once
// The curves behind path:NAME, as polylines in metres.

#include <string>
#include <vector>

#include "scheduling/motion/device.hpp"

namespace forefeel {

struct PathShape {
  std::vector<Vec3> lead;  // from rest to the first point of the loop; starts at 0
  std::vector<Vec3> loop;  // repeated; closed from its last point to its first
};

// InputError lists the names.
PathShape path_shape(const std::string& name, const DeviceContext& context);

}  // namespace forefeel
