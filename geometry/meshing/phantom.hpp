#pragma once
// Bodies made by code: liver (a smooth two-lobed body 22 cm long), beam (10 x 2 x 2 cm), ball (diameter 10 cm),
// slab (20 x 20 x 4 cm). Each carries the node groups "clamp" and "contact" (a patch around "tip").

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

std::vector<std::string> phantom_names();
Surface phantom_surface(std::string_view name);  // InputError lists the accepted names
// elements = 0: the phantom's own default (liver: 1777).
TetMesh phantom(std::string_view name, std::size_t elements = 0);
Vec3 phantom_tip(std::string_view name);  // where one would touch it [m]

}  // namespace forefeel
