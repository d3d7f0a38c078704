#pragma once
// Tetrahedra in a surface, as many as wanted. Lengths in [m].

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct TetrahedraliseOptions {
  std::size_t elements = 0;                     // wanted number, met within 5 %; 0: as the surface is
  std::optional<double> length = std::nullopt;  // rescale so that the longest side is this [m]
  std::string name = "surface";                 // what errors call it
  // For everything, repair and all tries included [s]. Not given: default_time_limit(elements).
  std::optional<double> time_limit = std::nullopt;
  const std::atomic<bool>* stop = nullptr;  // once true, it ends with an InputError "interrupted"
  // With any of these the triangles are remeshed by graded_surface.hpp, and `elements` is needed.
  std::optional<Toward> toward = std::nullopt;  // small elements there; otherwise edges are even
  std::optional<LowEnd> rim = std::nullopt;     // of the clamp: edges of the mesh run along it
  std::vector<int> marks = {};                  // by triangle; borders between different marks stay edges
  std::vector<Vec3> pins = {};                  // places of nodes that stay [m]
};
double default_time_limit(std::size_t elements);  // 120, or 1 for each 5000 elements if that is more [s]

struct TetrahedraliseReport {
  RepairReport repair;
  double hausdorff = 0;      // between the input surface and the boundary of the mesh [m]
  double near = 0, far = 0;  // edges wanted at the contact and far from it [m]; 0: not graded
};

// The number of tries is not known beforehand; it is at most `attempts`.
enum class MeshingStep : int { repair, resample, fill, compare };

struct MeshingProgress {
  MeshingStep step = MeshingStep::repair;
  int attempt = 0, attempts = 0;  // with a wanted number of elements: surface resolutions tried, from 1
  int fills = 0;                  // meshes of TetGen so far
};
const char* name(MeshingStep step);  // "repairing the surface"

// Repairs and decimates a surface and fills it with TetGen. Bisection finds the volume bound that gives the
// wanted number of elements. Runs in a child process, because CGAL and TetGen hang, crash or print on some inputs.
// InputError if the number cannot be met, if the time is up, or if the body is not 1e-6 to 1e6 m long. The calling
// thread calls `show` about ten times a second.
TetMesh tetrahedralise(const Surface& surface, const TetrahedraliseOptions& options,
                       TetrahedraliseReport* report = nullptr,
                       const std::function<void(const MeshingProgress&)>& show = {});

}  // namespace forefeel
