#pragma once
// How much a mesh deviates from the surface that it was made from, with advice in words.

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct Deviation {
  // (mesh - surface) / surface; NaN where the surface is not closed and so has no volume. Parts of a surface that
  // overlap count twice in its volume.
  double volume_change = std::numeric_limits<double>::quiet_NaN();
  double hausdorff = std::numeric_limits<double>::quiet_NaN();  // [m], of TetrahedraliseReport
  double longest_side = 0;                                      // of the mesh [m]
};
// hausdorff: NaN if it was not measured. length: of the longest side [m], where the mesh was scaled to one; it is then
// compared with the surface at that length. The mesh's own longest side is no measure of the scale, since coarse
// meshes cut off ends. repair: where facets were flipped or parts united, the volume of the repaired surface counts.
Deviation deviation_of(const Surface& surface, const TetMesh& mesh, double hausdorff,
                       std::optional<double> length = std::nullopt, const RepairReport& repair = {});

// A sentence about parts that cross, and one for each of the two deviations that is above 5 % (of the volume; of the
// longest side): what, how much, what to do.
std::vector<std::string> in_words(const Deviation& deviation, const RepairReport& repair);

}  // namespace forefeel
