#pragma once
// The curves behind PathMotion on a body that may be touched anywhere, as polylines of the tip in the axes of the
// mesh. They begin outside, press in to `depth` d along the mean normal n, and run at s - d n over the sites s:
//   line       15 cm over the surface, to and fro
//   raster     nine lines of 8 cm, 8 mm apart
//   palpation  twelve places: in, out, and outside the body to the next
//   tour       in, eight slides of 4 cm at changing depth, out
// A line ends early at the clamp. Places and directions are drawn from the seed.

#include "scheduling/motion/path_shapes.hpp"
#include "scheduling/motion/touch_surface.hpp"

namespace forefeel {

// InputError for a path around one place, of a device or its hand; nothing of the body is needed.
void check_on_surface(const DeviceSpec& device);

// InputError for another path, and for motion.where without a free part of the surface.
PathShape surface_shape(const PathMotion& motion, const TouchSurface& surface, std::uint64_t seed);

}  // namespace forefeel
