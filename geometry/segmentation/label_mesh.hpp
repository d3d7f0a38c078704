#pragma once
// Meshes a label volume with tetrahedra. A point has the label with the largest trilinear weight among the eight voxel
// centres around it; an interface lies where that label changes. CGAL's Mesh_3 (Boltcheva, Yvinec, Boissonnat 2009)
// samples the interfaces by restricted Delaunay refinement, so both sides share nodes and faces. Flat tetrahedra are
// then removed by perturbation and exudation (Cheng, Dey, Edelsbrunner, Facello, Teng 2000). Lengths in [m].

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/segmentation/label_volume.hpp"

namespace forefeel {

struct LabelMeshOptions {
  std::size_t elements = 20'000;                    // wanted number, met within 5 %
  std::map<std::int64_t, std::string> labels = {};  // label -> name; empty: every label but 0, as label_7
  std::string name = "labels";                      // what errors call the volume
  std::optional<double> length = {};                // rescale so that the longest side is this [m]
  std::optional<double> time_limit = {};  // for all of it [s]; nothing: default_time_limit(elements)
};

struct LabelRegion {
  std::string name;
  std::int64_t label = 0;
  std::size_t voxels = 0;
  std::size_t parts = 0;        // connected over faces of voxels
  bool touches_border = false;  // has a voxel in the outermost layer of the volume
  double voxel_volume = 0;      // of all its voxels, in the scale of the mesh [m^3]
  double mesh_volume = 0;       // [m^3]
  std::size_t elements = 0;
};

struct LabelMeshReport {
  std::vector<LabelRegion> regions;   // ascending label
  double hausdorff = 0;               // boundary of the mesh against that of the voxels [m]
  std::vector<std::string> warnings;  // labels at the border, lost or of one voxel; volumes that are far off
};

enum class LabelMeshStep : int { size, perturb, exude, compare };
std::string_view name(LabelMeshStep step);
struct LabelMeshProgress {
  LabelMeshStep step = LabelMeshStep::size;
  int meshes = 0;  // so far, in the search for the size
};

// Each label becomes an element group of that name. Runs in a child process with a time limit, as tetrahedralise()
// does. InputError if a wanted label is not in the volume (the message lists those that are), if the volume is all
// background, if the number of elements cannot be met, or if the time is up. `show` is called about ten times a second.
TetMesh mesh_labels(const LabelVolume& volume, const LabelMeshOptions& options, LabelMeshReport& report,
                    const std::function<void(const LabelMeshProgress&)>& show = {});

// The boundary of all wanted voxels: two triangles for each boundary face, facing outward (for a right-handed volume).
// wanted[v]: whether the label values[v] belongs to the body.
Surface voxel_surface(const LabelVolume& volume, const std::vector<char>& wanted);

}  // namespace forefeel
