#pragma once
// Writes regions and Delaunay cells for ParaView (.vtu with raw appended data), and tables (.csv). Labels in files for
// ParaView are numbers (0 safe, 1 sparse, 2 gap, 3 blank), with their names in an array of texts beside them. Lengths
// in [m].

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

// VTK_VOXELs with shared corners (region_cells.hpp): the parts of a label that are connected over points are
// its components. Cell data: label, label_name, component; from `components` (may be empty) also the number of
// safe neighbours and of bridge sides of the leaf's component.
void write_regions_vtu(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       std::span<const RegionComponent> components = {});
// What changed from one set of states to another: VTK_VOXELs with shared corners, cell data label_before,
// label_after and their names.
struct RegionChange {
  Box box;  // [m]
  Label before = Label::blank, after = Label::blank;
};
void write_changes_vtu(const std::filesystem::path& file, std::span<const RegionChange> changes);
// x,y,z (centre), dx,dy,dz (sides), label, component.
void write_regions_csv(const std::filesystem::path& file, std::span<const RegionLeaf> leaves);
// One tetrahedron for each finite Delaunay cell. Cell data: spread at the centroid, alpha (circumradius) [m].
void write_cells_vtu(const std::filesystem::path& file, const StateSpace& space);

}  // namespace forefeel
