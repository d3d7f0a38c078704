#pragma once
// Phantoms: synthetic bodies. liver (smooth, two lobes, 22 cm long), beam (10 x 2 x 2 cm), ball (diameter 10
// cm), slab (20 x 20 x 4 cm). Each has the node groups "clamp" and "contact"; the contact is a patch around
// phantom_tip().

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

std::vector<std::string> phantom_names();
Surface phantom_surface(std::string_view name);  // InputError lists the accepted names
// elements: how many tetrahedra, met within 5 %; 0: the default of the phantom (liver: 1777).
TetMesh phantom(std::string_view name, std::size_t elements = 0);
Vec3 phantom_tip(std::string_view name);  // middle of the contact patch [m]

}  // namespace forefeel
