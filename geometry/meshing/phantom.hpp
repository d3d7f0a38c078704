#pragma once
// Phantoms: synthetic bodies. liver (smooth, two lobes, 22 cm long), beam (10 x 2 x 2 cm), ball (diameter 10
// cm), slab (20 x 20 x 4 cm; its element group "lump" is a ball of 24 mm under the tip). Each has the node groups
// "clamp" and "contact"; the contact is a patch around phantom_tip().

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct SizeField;  // size_field.hpp

std::vector<std::string> phantom_names();
Surface phantom_surface(std::string_view name);  // InputError lists the accepted names
// elements: how many tetrahedra, met within 5 %; 0: the default of the phantom (liver: 1777).
TetMesh phantom(std::string_view name, std::size_t elements = 0);

struct PhantomOptions {
  std::size_t elements = 0;                  // as of phantom()
  Toward toward;                             // small elements there; the site is taken to the surface
  std::optional<LowEnd> rim = std::nullopt;  // of another clamp than the group's
};
// As phantom(), with small elements at a contact (size_field.hpp). Edges run along the rim of the clamp, and the group
// "clamp" holds the surface's nodes up to it. made: the wanted edges.
TetMesh graded_phantom(std::string_view name, const PhantomOptions& options, SizeField* made = nullptr);
Vec3 phantom_tip(std::string_view name);  // middle of the contact patch [m]

}  // namespace forefeel
