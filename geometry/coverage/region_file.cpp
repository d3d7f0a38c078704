#include "geometry/coverage/region_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/common/field.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/common/union_find.hpp"
#include "geometry/index/delaunay_index.hpp"
#include "geometry/mesh/vtu_writer.hpp"

namespace forefeel {
namespace {

using Planes = std::array<std::vector<double>, 3>;  // coordinates of all faces, rising [m]

// A box between planes, by their numbers.
struct Cell {
  std::array<std::uint32_t, 3> low{}, high{};
  std::uint32_t leaf = 0;
};

// Faces of neighbours may differ by rounding; coordinates that differ by less than this count as equal.
double tolerance(const std::vector<double>& sorted) {
  return sorted.empty() ? 0 : 1e-9 * std::max(sorted.back() - sorted.front(), std::abs(sorted.back()));
}

Planes planes_of(std::span<const RegionLeaf> leaves) {
  Planes planes;
  for (unsigned axis = 0; axis < 3; ++axis) {
    std::vector<double>& all = planes[axis];
    for (const RegionLeaf& leaf : leaves)
      for (const Vec3* corner : {&leaf.box.low, &leaf.box.high}) all.push_back((*corner)[axis]);
    std::ranges::sort(all);
    std::vector<double> apart;
    const double least = tolerance(all);
    for (const double value : all)
      if (apart.empty() || value > apart.back() + least) apart.push_back(value);
    all = std::move(apart);
  }
  return planes;
}

std::uint32_t plane_at(const std::vector<double>& planes, double value) {
  const double least = tolerance(planes);
  const auto found = std::ranges::lower_bound(planes, value - least);
  return static_cast<std::uint32_t>(
      std::min<std::ptrdiff_t>(found - planes.begin(), static_cast<std::ptrdiff_t>(planes.size()) - 1));
}

std::vector<Cell> cells_of(std::span<const RegionLeaf> leaves, const Planes& planes) {
  std::vector<Cell> cells(leaves.size());
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    cells[i].leaf = i;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto a = axis;
      cells[i].low[axis] = plane_at(planes[axis], leaves[i].box.low[a]);
      cells[i].high[axis] = plane_at(planes[axis], leaves[i].box.high[a]);
    }
  }
  return cells;
}

// Corners of one component at one place are one point.
using Corner = std::array<std::uint32_t, 4>;  // component, then the planes along x, y, z

Corner corner_of(const Cell& cell, std::uint32_t component, unsigned number) {
  Corner corner{component, 0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis)
    corner[axis + 1] = (number >> axis) & 1 ? cell.high[axis] : cell.low[axis];
  return corner;
}

struct Numbered {
  std::vector<Corner> points;  // sorted
  std::vector<std::array<std::uint32_t, 8>> corners;
};

Numbered number_corners(std::span<const RegionLeaf> leaves, const std::vector<Cell>& cells) {
  Numbered result;
  result.points.reserve(8 * cells.size());
  for (const Cell& cell : cells)
    for (unsigned k = 0; k < 8; ++k) result.points.push_back(corner_of(cell, leaves[cell.leaf].component, k));
  std::ranges::sort(result.points);
  result.points.erase(std::unique(result.points.begin(), result.points.end()), result.points.end());
  result.corners.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (unsigned k = 0; k < 8; ++k) {
      const Corner corner = corner_of(cells[i], leaves[cells[i].leaf].component, k);
      result.corners[i][k] =
          static_cast<std::uint32_t>(std::ranges::lower_bound(result.points, corner) - result.points.begin());
    }
  return result;
}

// Cells that are connected over shared corners have one number.
std::vector<std::uint32_t> connected(const Numbered& numbered) {
  UnionFind sets(numbered.points.size());
  for (const auto& corners : numbered.corners)
    for (const std::uint32_t point : corners) sets.join(corners[0], point);
  std::vector<std::uint32_t> set;
  set.reserve(numbered.corners.size());
  for (const auto& corners : numbered.corners) set.push_back(sets.find(corners[0]));
  return set;
}

bool overlap(const Cell& a, const Cell& b, std::size_t axis) {
  return a.low[axis] < b.high[axis] && b.low[axis] < a.high[axis];
}

// The axes (as bits) along which `cell` is to be cut so that its corners come nearer to those of `other`, which
// shares a part of a facet across `normal`.
unsigned axes_to_cut(const Cell& cell, const Cell& other, std::size_t normal) {
  unsigned axes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis == normal) continue;
    const auto inside = [&](std::uint32_t plane) {
      return cell.low[axis] < plane && plane < cell.high[axis];
    };
    if (inside(other.low[axis]) || inside(other.high[axis])) axes |= 1u << axis;
  }
  return axes;
}

// The cells of one component, by the plane of their low and of their high facet along each axis.
struct Facets {
  std::map<std::pair<std::size_t, std::uint32_t>, std::vector<std::uint32_t>> low, high;

  Facets(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& members) {
    for (const std::uint32_t i : members)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[{axis, cells[i].low[axis]}].push_back(i);
        high[{axis, cells[i].high[axis]}].push_back(i);
      }
  }
};

// Marks the cells of a component that must be cut for its parts (`set`) to be connected.
void mark_part(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& members,
               const std::vector<std::uint32_t>& set, std::vector<unsigned>& cut) {
  std::map<std::uint32_t, std::size_t> size;
  for (const std::uint32_t i : members) ++size[set[i]];
  if (size.size() < 2) return;
  const std::uint32_t largest =
      std::ranges::max_element(size, {}, [](const auto& entry) { return entry.second; })->first;
  const Facets facets(cells, members);
  for (const std::uint32_t i : members) {
    if (set[i] == largest) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const bool upwards : {false, true}) {
        const auto& beyond = upwards ? facets.low : facets.high;
        const auto found = beyond.find({axis, upwards ? cells[i].high[axis] : cells[i].low[axis]});
        if (found == beyond.end()) continue;
        for (const std::uint32_t j : found->second) {
          if (set[j] == set[i] || !overlap(cells[i], cells[j], (axis + 1) % 3) ||
              !overlap(cells[i], cells[j], (axis + 2) % 3))
            continue;
          cut[j] |= axes_to_cut(cells[j], cells[i], axis);
          cut[i] |= axes_to_cut(cells[i], cells[j], axis);
        }
      }
  }
}

// Cuts each marked cell at the plane nearest to its middle.
void cut_cells(const Planes& planes, const std::vector<unsigned>& cut, std::vector<Cell>& cells) {
  std::vector<Cell> result;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::vector<Cell> parts{cells[i]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!((cut[i] >> axis) & 1)) continue;
      const std::vector<double>& at = planes[axis];
      const double middle = 0.5 * (at[cells[i].low[axis]] + at[cells[i].high[axis]]);
      std::uint32_t best = cells[i].low[axis] + 1;
      for (std::uint32_t k = best; k < cells[i].high[axis]; ++k)
        if (std::abs(at[k] - middle) < std::abs(at[best] - middle)) best = k;
      const std::size_t before = parts.size();
      for (std::size_t k = 0; k < before; ++k) {
        parts.push_back(parts[k]);
        parts[k].high[axis] = parts.back().low[axis] = best;
      }
    }
    result.insert(result.end(), parts.begin(), parts.end());
  }
  cells = std::move(result);
}

}  // namespace

RegionCells cells_with_shared_corners(std::span<const RegionLeaf> leaves) {
  const Planes planes = planes_of(leaves);
  std::vector<Cell> cells = cells_of(leaves, planes);
  Numbered numbered = number_corners(leaves, cells);
  for (;;) {
    const std::vector<std::uint32_t> set = connected(numbered);
    std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // of each component
    for (std::uint32_t i = 0; i < cells.size(); ++i) members[leaves[cells[i].leaf].component].push_back(i);
    std::vector<unsigned> cut(cells.size(), 0);
    for (const auto& [component, own] : members) mark_part(cells, own, set, cut);
    if (std::ranges::all_of(cut, [](unsigned axes) { return axes == 0; })) break;
    cut_cells(planes, cut, cells);
    numbered = number_corners(leaves, cells);
  }
  RegionCells result;
  for (const Corner& corner : numbered.points)
    result.points.emplace_back(planes[0][corner[1]], planes[1][corner[2]], planes[2][corner[3]]);
  result.corners = std::move(numbered.corners);
  for (const Cell& cell : cells) result.leaf.push_back(cell.leaf);
  return result;
}

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
                       std::span<const RegionComponent> components, const Mat3& back) {
  RegionCells cells = cells_with_shared_corners(leaves);
  for (Vec3& point : cells.points) point = back * point;
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

void write_regions_csv(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       const Mat3& back) {
  OutputFile out(file);
  out.write("x,y,z,dx,dy,dz,label,component\n");
  write_lines(out, leaves.size(), [&](std::size_t i) {
    const RegionLeaf& leaf = leaves[i];
    const Vec3 c = back * leaf.box.centre(), d = leaf.box.size();
    return fmt::format("{},{},{},{},{},{},{},{}\n", c.x(), c.y(), c.z(), d.x(), d.y(), d.z(),
                       name(leaf.label), leaf.component);
  });
  out.commit();
}

void write_cells_vtu(const std::filesystem::path& file, const StateSpace& space, const Mat3& back) {
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
  for (std::uint32_t id = 0; id < space.size(); ++id) points.push_back(back * space[{id}].at);
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
