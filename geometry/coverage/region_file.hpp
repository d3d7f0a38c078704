#pragma once
// Writes regions and Delaunay cells for ParaView (.vtu with raw appended data), and tables (.csv). Labels in files for
// ParaView are numbers (0 safe, 1 sparse, 2 gap, 3 blank), with their names in an array of texts beside them. Lengths
// in [m]. back: from the axes of the leaves, or of the space, to those of the file.

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/coverage/region_summary.hpp"
#include "geometry/coverage/state_space.hpp"

namespace forefeel {

// VTK_VOXELs with shared corners: the parts of a label that are connected over points are
// its components. Cell data: label, label_name, component; from `components` (may be empty) also the number of
// safe neighbours and of bridge sides of the leaf's component.
void write_regions_vtu(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       std::span<const RegionComponent> components = {}, const Mat3& back = Mat3::Identity());
// What changed from one set of states to another: VTK_VOXELs with shared corners, cell data label_before,
// label_after and their names.
struct RegionChange {
  Box box;  // [m]
  Label before = Label::blank, after = Label::blank;
};
void write_changes_vtu(const std::filesystem::path& file, std::span<const RegionChange> changes);
// x,y,z (centre), dx,dy,dz (sides, along the axes of the leaves), label, component.
void write_regions_csv(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       const Mat3& back = Mat3::Identity());
// One tetrahedron for each finite Delaunay cell. Cell data: spread at the centroid, alpha (circumradius) [m].
void write_cells_vtu(const std::filesystem::path& file, const StateSpace& space,
                     const Mat3& back = Mat3::Identity());

// The leaves of regions as boxes with shared corners, so that other programs find the connected components. Two boxes
// of one component that share a facet are connected by shared corners, directly or through other boxes. Boxes of
// different components share no corner.
//
// A small leaf in the middle of a large leaf's facet shares no corner with the large leaf. If nothing else connects the
// two, the large leaf is cut into smaller boxes. So there may be a few more boxes than leaves.
struct RegionCells {
  std::vector<Vec3> points;                           // #P [m]
  std::vector<std::array<std::uint32_t, 8>> corners;  // #C, into points: x fastest, then y, then z
  std::vector<std::uint32_t> leaf;                    // #C: the leaf that the box is a part of
};

RegionCells cells_with_shared_corners(std::span<const RegionLeaf> leaves);

}  // namespace forefeel
