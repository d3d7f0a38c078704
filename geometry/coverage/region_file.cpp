#include "geometry/coverage/region_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "geometry/common/output_file.hpp"
#include "geometry/coverage/region_cells.hpp"
#include "geometry/index/delaunay_index.hpp"

namespace forefeel {
namespace {

// Collects arrays; then writes their XML elements and, after these, their bytes.
class AppendedArrays {
 public:
  template <class T>
  std::string add(std::string_view type, std::string_view name, int width, const std::vector<T>& values) {
    const std::uint64_t bytes = values.size() * sizeof(T);
    std::string head = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
        type, name, width, data_.size());
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    if (bytes > 0) data_.append(reinterpret_cast<const char*>(values.data()), bytes);
    return head;
  }
  // One text for each cell or point: vtkStringArray.
  std::string add_texts(std::string_view name, const std::vector<std::string_view>& values) {
    std::vector<char> bytes;  // each text ends with a zero
    for (const std::string_view value : values) {
      bytes.insert(bytes.end(), value.begin(), value.end());
      bytes.push_back('\0');
    }
    return add("String", name, 1, bytes);
  }
  const std::string& data() const { return data_; }

 private:
  std::string data_;
};

struct Grid {
  std::vector<double> points;  // #P x 3
  std::vector<std::int64_t> connectivity;
  int corners = 0;        // of every cell
  std::uint8_t type = 0;  // VTK cell type
};

void write_grid(const std::filesystem::path& file, const Grid& grid, const std::string& cell_data,
                AppendedArrays& arrays) {
  const std::size_t cells = grid.connectivity.size() / static_cast<std::size_t>(grid.corners);
  std::vector<std::int64_t> offsets(cells);
  for (std::size_t i = 0; i < cells; ++i) offsets[i] = static_cast<std::int64_t>(i + 1) * grid.corners;
  const std::vector<std::uint8_t> types(cells, grid.type);
  OutputFile out(file);
  out.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n");
  out.write(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<CellData>\n{}</CellData>\n",
                        grid.points.size() / 3, cells, cell_data));
  out.write("<Points>\n" + arrays.add("Float64", "position", 3, grid.points) + "</Points>\n<Cells>\n");
  out.write(arrays.add("Int64", "connectivity", 1, grid.connectivity));
  out.write(arrays.add("Int64", "offsets", 1, offsets) + arrays.add("UInt8", "types", 1, types));
  out.write("</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
  out.write(arrays.data());
  out.write("\n</AppendedData>\n</VTKFile>\n");
  out.commit();
}

}  // namespace

namespace {

Grid voxels_of(const RegionCells& cells) {
  Grid grid{.points = {}, .connectivity = {}, .corners = 8, .type = 11};  // VTK_VOXEL: x fastest, y, z
  for (const Vec3& point : cells.points) grid.points.insert(grid.points.end(), point.begin(), point.end());
  for (const auto& corners : cells.corners)
    grid.connectivity.insert(grid.connectivity.end(), corners.begin(), corners.end());
  return grid;
}

// The array of label numbers, and an array of their names.
std::string labels(const std::string& array, const std::vector<Label>& label, AppendedArrays& arrays) {
  std::vector<std::uint8_t> numbers;
  std::vector<std::string_view> names;
  for (const Label l : label) {
    numbers.push_back(static_cast<std::uint8_t>(l));
    names.push_back(name(l));
  }
  return arrays.add("UInt8", array, 1, numbers) + arrays.add_texts(array + "_name", names);
}

}  // namespace

void write_regions_vtu(const std::filesystem::path& file, std::span<const RegionLeaf> leaves,
                       std::span<const RegionComponent> components) {
  const RegionCells cells = cells_with_shared_corners(leaves);
  std::vector<Label> label;
  std::vector<std::int32_t> component, safe, sides;
  for (const std::uint32_t i : cells.leaf) {
    const RegionLeaf& leaf = leaves[i];
    label.push_back(leaf.label);
    component.push_back(static_cast<std::int32_t>(leaf.component));
    if (components.empty()) continue;
    safe.push_back(static_cast<std::int32_t>(components[leaf.component].safe_neighbours.size()));
    sides.push_back(static_cast<std::int32_t>(components[leaf.component].sides.size()));
  }
  AppendedArrays arrays;
  std::string data = labels("label", label, arrays) + arrays.add("Int32", "component", 1, component);
  if (!components.empty())
    data += arrays.add("Int32", "safe_components", 1, safe) + arrays.add("Int32", "bridge_sides", 1, sides);
  write_grid(file, voxels_of(cells), data, arrays);
}

void write_changes_vtu(const std::filesystem::path& file, std::span<const RegionChange> changes) {
  std::vector<RegionLeaf> leaves;
  for (const RegionChange& change : changes) leaves.push_back({.box = change.box});
  const RegionCells cells = cells_with_shared_corners(leaves);
  std::vector<Label> before, after;
  for (const std::uint32_t i : cells.leaf) {
    before.push_back(changes[i].before);
    after.push_back(changes[i].after);
  }
  AppendedArrays arrays;
  const std::string data = labels("label_before", before, arrays) + labels("label_after", after, arrays);
  write_grid(file, voxels_of(cells), data, arrays);
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
  Grid grid;
  grid.corners = 4;
  grid.type = 10;  // VTK_TETRA
  for (std::uint32_t id = 0; id < space.size(); ++id)
    for (int axis = 0; axis < 3; ++axis) grid.points.push_back(space[{id}].at[axis]);
  std::vector<double> spread, alpha;
  for (const DelaunayIndex::Cell& cell : space.delaunay().cells()) {
    Vec3 middle = Vec3::Zero();
    for (const StateId id : cell.states) middle += 0.25 * space[id].at;
    double sum = 0;
    for (const StateId id : cell.states) {
      sum += 0.25 * (space[id].at - middle).squaredNorm();
      grid.connectivity.push_back(id.value);
    }
    spread.push_back(std::sqrt(sum));
    alpha.push_back(cell.circumradius);
  }
  AppendedArrays arrays;
  const std::string data =
      arrays.add("Float64", "spread", 1, spread) + arrays.add("Float64", "alpha", 1, alpha);
  write_grid(file, grid, data, arrays);
}

void write_pvd(const std::filesystem::path& file, std::span<const SeriesEntry> entries) {
  OutputFile out(file);
  out.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n");
  for (const SeriesEntry& entry : entries)
    out.write(fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", entry.time,
                          entry.part, entry.file));
  out.write("</Collection>\n</VTKFile>\n");
  out.commit();
}

}  // namespace forefeel
