#pragma once
// How far tetrahedralise() has come. How many tries it takes is not known beforehand; at most `attempts`.

#include <functional>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

enum class MeshingStep : int { repair, resample, fill, compare };

struct MeshingProgress {
  MeshingStep step = MeshingStep::repair;
  int attempt = 0, attempts = 0;  // with a wanted number of elements: surfaces of another fineness; from 1
  int fills = 0;                  // meshes of TetGen so far
};
const char* name(MeshingStep step);  // "repairing the surface"

// tetrahedralise() (surface.hpp); show is called about ten times in a second by the calling thread.
TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report, const std::function<void(const MeshingProgress&)>& show);

}  // namespace forefeel
