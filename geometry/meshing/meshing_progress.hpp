#pragma once
// Progress of tetrahedralise(). The number of tries is not known beforehand; it is at most `attempts`.

#include <functional>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

enum class MeshingStep : int { repair, resample, fill, compare };

struct MeshingProgress {
  MeshingStep step = MeshingStep::repair;
  int attempt = 0, attempts = 0;  // with a wanted number of elements: surface resolutions tried, from 1
  int fills = 0;                  // meshes of TetGen so far
};
const char* name(MeshingStep step);  // "repairing the surface"

// tetrahedralise() of surface.hpp with progress; the calling thread calls `show` about ten times a second.
TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report, const std::function<void(const MeshingProgress&)>& show);

}  // namespace forefeel
