#pragma once
// Fills a closed surface without self-intersections with tetrahedra, by TetGen. TetGen throws int, and
// crashes or loops on some inputs. It therefore runs in a forked child process (child_process.hpp), and the
// caller only sees success or a reason. A mesh that leaves the surface's box, or that has another volume, is
// no success.

#include <atomic>
#include <chrono>
#include <optional>
#include <string>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct TetFillOptions {
  double max_volume = 0;                        // bound on each tetrahedron [m^3]; 0: none
  double radius_edge = 1.3;                     // bound on circumradius / shortest edge (TetGen -q)
  double min_dihedral_deg = 14;                 // wanted; TetGen does not always reach it
  bool keep_surface = true;                     // no new nodes on the surface (TetGen -Y)
  bool improve = true;                          // flips and smoothing afterwards (tet_improve.hpp)
  std::chrono::milliseconds patience{120'000};  // then the child process is killed
  std::atomic<int>* fills = nullptr;            // if given, counts TetGen's meshes
};

// Nodes of the surface come first. Nothing, and the reason in `problem`, if TetGen fails.
std::optional<TetMesh> fill_with_tets(const Surface& surface, const TetFillOptions& options,
                                      std::string& problem);

// TetGen fills every region between facets. This removes the regions outside the surface (winding number near
// 0), as the cavity within a shell. The mesh must contain the surface.
void drop_cavities(TetMesh& mesh, const Surface& surface);

// Fills with `elements` tetrahedra: bisects the volume bound until their number is within `share` of it, or
// as near as it gets; the caller checks the number.
struct CountedFill {
  std::optional<TetMesh> mesh;
  bool too_fine = false;  // more tetrahedra than wanted even without a bound: the surface must be coarser
  std::string problem;
};
CountedFill fill_to_count(const Surface& surface, std::size_t elements, double share,
                          TetFillOptions options = {});

}  // namespace forefeel
