#pragma once
// Fills a closed surface without self-intersections with tetrahedra, using TetGen. TetGen throws int, and it
// crashes or hangs on some inputs. It therefore runs in a forked child process (child_process.hpp); the caller
// gets a mesh or the reason of the failure. A mesh that leaves the surface's box, or whose volume differs from
// the surface's, counts as a failure.

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct TetFillOptions {
  double max_volume = 0;                        // bound on each tetrahedron [m^3], or as `size` says; 0: none
  bool keep_surface = true;                     // no new nodes on the surface (TetGen -Y)
  bool improve = true;                          // flips and smoothing afterwards (tet_improve.hpp)
  std::chrono::milliseconds patience{120'000};  // then the child process is killed
  std::atomic<int>* fills = nullptr;            // if given, counts TetGen's meshes
  // Wanted edge [m] at a point; if given, the bound on a tetrahedron's volume is max_volume times its cube at the
  // centroid.
  std::function<double(const Vec3&)> size = {};
  // As of ImproveOptions; held is by node of the surface.
  std::function<Vec3(const Vec3&)> onto = {};
  std::vector<char> held = {};
};

// Nodes of the surface come first. Nothing, and the reason in `problem`, if TetGen fails.
std::optional<TetMesh> fill_with_tets(const Surface& surface, const TetFillOptions& options,
                                      std::string& problem);

// TetGen fills every region that facets enclose. This function removes the regions outside the surface (winding
// number near 0), such as the cavity within a shell. The mesh must contain the surface.
void drop_cavities(TetMesh& mesh, const Surface& surface);

// Fills with about `elements` tetrahedra: bisects the volume bound until their number is within `share` of the
// wanted one. If that cannot be reached, the nearest number is returned; the caller checks it.
struct CountedFill {
  std::optional<TetMesh> mesh;
  bool too_fine = false;  // more tetrahedra than wanted even without a bound: the surface must be coarser
  std::string problem;
};
CountedFill fill_to_count(const Surface& surface, std::size_t elements, double share,
                          TetFillOptions options = {});

}  // namespace forefeel
