#include "geometry/coverage/region_file.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_cells.hpp"
#include "geometry/index/delaunay_index.hpp"
#include "geometry/mesh/vtu_writer.hpp"

namespace forefeel {
namespace {

// VTK_VOXELs with shared corners; `data` writes the cell data.
template <class Data>
void write_voxels(const std::filesystem::path& file, const RegionCells& cells, Data&& data) {
  VtuWriter out(file, VtuData::raw);
  out.begin(cells.points.size(), cells.corners.size());
  out.section("CellData");
  data(out);
  out.points(cells.points);
  out.cells(cells.corners, vtk_cell::voxel);
  out.finish();
}

// The array of label numbers, and an array of their names.
template <class LabelOf>
void labels(VtuWriter& out, const std::string& array, const RegionCells& cells, LabelOf&& label_of) {
  std::vector<std::uint8_t> numbers;
  std::vector<char> names;  // each ends with a zero
  for (const std::uint32_t i : cells.leaf) {
    const Label label = label_of(i);
    numbers.push_back(static_cast<std::uint8_t>(label));
    const std::string_view word = name(label);
    names.insert(names.end(), word.begin(), word.end());
    names.push_back('\0');
  }
  out.array<std::uint8_t>(array, 1, numbers);
  out.array<char>(array + "_name", 1, names);
}

}  // namespace

void write_regions_vtu(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       std::span<const RegionComponent> components) {
  const RegionCells cells = cells_with_shared_corners(leaves);
  write_voxels(file, cells, [&](VtuWriter& out) {
    const auto counts = [&](const char* array, auto&& count_of) {
      out.array<std::int32_t>(array, cells.leaf.size(), 1,
                              [&](std::size_t i, int) { return count_of(leaves[cells.leaf[i]].component); });
    };
    labels(out, "label", cells, [&](std::uint32_t i) { return leaves[i].label; });
    counts("component", [](std::size_t c) { return c; });
    if (components.empty()) return;
    counts("safe_components", [&](std::size_t c) { return components[c].safe_neighbours.size(); });
    counts("bridge_sides", [&](std::size_t c) { return components[c].sides.size(); });
  });
}

void write_changes_vtu(const std::filesystem::path& file, std::span<const RegionChange> changes) {
  std::vector<RegionLeaf> leaves;
  for (const RegionChange& change : changes) leaves.push_back({.box = change.box});
  const RegionCells cells = cells_with_shared_corners(leaves);
  write_voxels(file, cells, [&](VtuWriter& out) {
    labels(out, "label_before", cells, [&](std::uint32_t i) { return changes[i].before; });
    labels(out, "label_after", cells, [&](std::uint32_t i) { return changes[i].after; });
  });
}

void write_regions_csv(const std::filesystem::path& file, std::span<const RegionLeaf> leaves) {
  OutputFile out(file);
  out.write("x,y,z,dx,dy,dz,label,component\n");
  for (const RegionLeaf& leaf : leaves) {
    const Vec3 c = leaf.box.centre(), d = leaf.box.size();
    out.write(fmt::format("{},{},{},{},{},{},{},{}\n", c.x(), c.y(), c.z(), d.x(), d.y(), d.z(),
                          name(leaf.label), leaf.component));
  }
  out.commit();
}

void write_cells_vtu(const std::filesystem::path& file, const StateSpace& space) {
  std::vector<double> spread, alpha;
  std::vector<std::int64_t> connectivity;
  for (const DelaunayIndex::Cell& cell : space.delaunay().cells()) {
    Vec3 middle = Vec3::Zero();
    for (const StateId id : cell.states) middle += 0.25 * space[id].at;
    double sum = 0;
    for (const StateId id : cell.states) {
      sum += 0.25 * (space[id].at - middle).squaredNorm();
      connectivity.push_back(id.value);
    }
    spread.push_back(std::sqrt(sum));
    alpha.push_back(cell.circumradius);
  }
  std::vector<Vec3> points;
  for (std::uint32_t id = 0; id < space.size(); ++id) points.push_back(space[{id}].at);
  VtuWriter out(file, VtuData::raw);
  out.begin(points.size(), spread.size());
  out.section("CellData");
  out.array<double>("spread", 1, spread);
  out.array<double>("alpha", 1, alpha);
  out.points(points);
  out.cells(connectivity, 4, vtk_cell::tetra);
  out.finish();
}

}  // namespace forefeel
