#pragma once
// The exact shapes of the smooth phantoms, and the surface of the others. Private to this room.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/meshing/relax.hpp"

namespace forefeel {

ImplicitSurface liver_body();  // before it is scaled to its length of 22 cm
// Farthest point of a smooth body along a direction, by ascent along the surface.
Vec3 extreme(const ImplicitSurface& body, const Vec3& direction);

// The body scaled to its length, and the points that every triangulation of it holds.
struct Liver {
  ImplicitSurface unscaled = liver_body();
  Vec3 left = extreme(unscaled, -Vec3::UnitX()), right = extreme(unscaled, Vec3::UnitX());
  Vec3 top;  // above the thickest place
  double scale = 0.22 / (right.x() - left.x());

  Liver();
  Surface surface(int n) const;  // of 20 n^2 triangles
};
const Liver& liver();

struct Blueprint {
  std::string_view name;
  std::size_t elements;  // default
  Vec3 tip;
};
const Blueprint& blueprint(std::string_view name);  // InputError lists the known ones
std::vector<std::string> blueprint_names();

void mark_lump(std::string_view name,
               TetMesh& mesh);                // of the slab: element group "lump", 18 mm below the tip
double phantom_patch(std::string_view name);  // radius of the group "contact" [m]

bool within_share(std::size_t count, std::size_t asked);  // of 5 %
// The subdivision n whose triangles are about as large as the faces of `elements` equal tetrahedra in the body.
int frequency_for(std::size_t elements);
Surface smooth_surface(std::string_view name, int n);  // of liver and ball: 20 n^2 triangles

bool is_box(std::string_view name);
Box box_of(std::string_view name);  // of a phantom that is one

}  // namespace forefeel
