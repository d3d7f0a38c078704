#pragma once
// TetGen behind a small door: fills a closed, intersection-free surface with tetrahedra. TetGen throws int, and
// crashes or loops on some inputs; it runs in a forked child, so none of that reaches the caller.

#include <chrono>
#include <optional>
#include <string>

#include "geometry/meshing/surface.hpp"

namespace forefeel {

struct TetFillOptions {
  double max_volume = 0;               // bound on each tetrahedron [m^3]; 0: none
  double radius_edge = 1.3;            // bound on circumradius / shortest edge (TetGen -q)
  double min_dihedral_deg = 14;        // asked of TetGen, not always reached
  bool keep_surface = true;            // no new nodes on the surface (TetGen -Y)
  bool improve = true;                 // flips and smoothing afterwards, see tet_improve.hpp
  std::chrono::seconds patience{120};  // after that the child is ended
};

// Nodes of the surface come first. Empty with a reason in `problem` where TetGen gives up.
std::optional<TetMesh> fill_with_tets(const Surface& surface, const TetFillOptions& options,
                                      std::string& problem);

// TetGen fills every region that facets bound. Takes those out that lie outside the surface (winding number near 0),
// as the hollow between two nested shells does. The surface must be kept in the mesh.
void drop_cavities(TetMesh& mesh, const Surface& surface);

// The same with the volume bound bisected until the count is within `share` of `elements`, or as near as it gets; the
// caller looks. `too_fine`: even without a bound there are more tetrahedra than asked, so the surface must be coarser.
struct CountedFill {
  std::optional<TetMesh> mesh;
  bool too_fine = false;
  std::string problem;
};
CountedFill fill_to_count(const Surface& surface, std::size_t elements, double share,
                          TetFillOptions options = {});

}  // namespace forefeel
