// Meshes of VTK: legacy .vtk with DATASET UNSTRUCTURED_GRID (vtk_legacy.hpp), and .vtu (vtk_xml.hpp), read and written.
// Points, lines and faces among the cells are passed over; other volume cells are refused. Cell arrays that label the
// tetrahedra become element groups, arrays of 0 and 1 in PointData of .vtu node groups. Pieces of .vtu are joined.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/mesh_formats.hpp"
#include "geometry/mesh/vtk_legacy.hpp"
#include "geometry/mesh/vtk_xml.hpp"
#include "geometry/mesh/vtu_writer.hpp"

namespace forefeel {

// ---- cells, and legacy files

namespace {

std::string name_of_cell(std::int64_t type) {
  static const std::map<std::int64_t, const char*> names{
      {11, "voxels"},    {12, "hexahedra"},
      {13, "wedges"},    {14, "pyramids"},
      {25, "hexahedra"}, {26, "wedges"},
      {27, "pyramids"},  {29, "hexahedra"},
      {42, "polyhedra"}, {71, "tetrahedra of higher order"}};
  const auto found = names.find(type);
  return found == names.end() ? fmt::format("cells of VTK type {}", type)
                              : fmt::format("{} (cells of VTK type {})", found->second, type);
}

}  // namespace

void add_vtk_cell(TetMesh& mesh, std::int64_t type, std::span<const std::int64_t> nodes,
                  const std::string& where) {
  constexpr std::int64_t tetra = 10, second_order_tetra = 24;
  static const std::set<std::int64_t> flat{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 36};
  if (flat.contains(type)) return;
  if (type != tetra && type != second_order_tetra)
    throw InputError({.file = where}, fmt::format("{} are not read, {}", name_of_cell(type), not_tetrahedra));
  const std::size_t expected = type == tetra ? 4 : 10;
  if (nodes.size() != expected)
    throw InputError({.file = where},
                     fmt::format("a tetrahedron with {} nodes, expected {}", nodes.size(), expected));
  std::array<NodeIndex, 10> of{};
  for (std::size_t k = 0; k < expected; ++k) {
    if (nodes[k] < 0 || nodes[k] >= static_cast<std::int64_t>(mesh.nodes.size()))
      throw InputError({.file = where}, fmt::format("a cell names point {}, expected 0 to {}", nodes[k],
                                                    static_cast<std::int64_t>(mesh.nodes.size()) - 1));
    of[k] = static_cast<NodeIndex>(nodes[k]);
  }
  const Tet corners{of[0], of[1], of[2], of[3]};
  if (type == tetra)
    mesh.tets.push_back(corners);
  else
    add_second_order(mesh, corners, {of[4], of[5], of[6], of[7], of[8], of[9]});
}

TetMesh read_vtk_legacy(Scanner in) {
  const std::string where = in.name();
  const VtkLegacyFile file = read_vtk_file(std::move(in));
  if (file.polydata)
    throw InputError({.file = where}, "DATASET POLYDATA is a surface, expected UNSTRUCTURED_GRID");
  const VtkCells& cells = file.cells.at("cells");
  if (file.types.size() != cells.size())
    throw InputError({.file = where},
                     fmt::format("{} cells, but {} cell types", cells.size(), file.types.size()));
  TetMesh mesh{.nodes = file.points, .tets = {}, .groups = {}};
  std::vector<TetIndex> tet_of_cell(cells.size(), no_tet);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t before = mesh.tets.size();
    add_vtk_cell(
        mesh, file.types[i],
        std::span(cells.connectivity).subspan(cells.offsets[i], cells.offsets[i + 1] - cells.offsets[i]),
        where);
    if (mesh.tets.size() > before) tet_of_cell[i] = static_cast<TetIndex>(before);
  }
  for (const auto& [name, values] : file.cell_arrays) {
    std::vector<CellLabel> labels;
    for (std::size_t i = 0; i < std::min(values.size(), tet_of_cell.size()); ++i)
      if (tet_of_cell[i] != no_tet) labels.push_back({tet_of_cell[i], values[i]});
    add_label_groups(mesh, name, labels);
  }
  return mesh;
}

// ---- .vtu

namespace {

class VtuReader {
 public:
  explicit VtuReader(Scanner in) : in_(std::move(in), "UnstructuredGrid") {}

  TetMesh read() {
    in_.read([&](const VtkXmlPiece& piece) {
      if (in_.count(piece, "NumberOfPoints") == 0 && in_.count(piece, "NumberOfCells") == 0) return;
      const std::size_t first = mesh_.nodes.size();
      take_labels(piece, join(piece));
      take_masks(piece, first);
    });
    for (const auto& [name, labels] : labels_) add_label_groups(mesh_, name, labels);
    return std::move(mesh_);
  }

 private:
  // The tetrahedron of each cell of the piece; no_tet for other cells.
  std::vector<TetIndex> join(const VtkXmlPiece& piece) {
    const std::size_t n_points = in_.count(piece, "NumberOfPoints"),
                      n_cells = in_.count(piece, "NumberOfCells");
    const auto first = static_cast<std::int64_t>(mesh_.nodes.size());
    const std::vector<double> points = in_.reals(in_.array(piece, "Points", ""));
    if (points.size() != 3 * n_points)
      throw InputError({.file = in_.name()},
                       fmt::format("{} coordinates, expected {}", points.size(), 3 * n_points));
    for (std::size_t i = 0; i < n_points; ++i)
      mesh_.nodes.emplace_back(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    if (n_cells == 0) return {};
    std::vector<std::int64_t> connectivity = in_.integers(in_.array(piece, "Cells", "connectivity"));
    const std::vector<std::int64_t> offsets = in_.integers(in_.array(piece, "Cells", "offsets")),
                                    types = in_.integers(in_.array(piece, "Cells", "types"));
    if (offsets.size() != n_cells || types.size() != n_cells)
      throw InputError({.file = in_.name()}, fmt::format("{} offsets and {} types, expected {}",
                                                         offsets.size(), types.size(), n_cells));
    for (auto& node : connectivity) {
      if (node < 0 || node >= static_cast<std::int64_t>(n_points))
        throw InputError({.file = in_.name()}, fmt::format("a cell names point {}, expected 0 to {}", node,
                                                           static_cast<std::int64_t>(n_points) - 1));
      node += first;
    }
    std::vector<TetIndex> tet_of_cell(n_cells, no_tet);
    std::int64_t begin = 0;
    for (std::size_t i = 0; i < n_cells; begin = offsets[i], ++i) {
      if (offsets[i] < begin || offsets[i] > static_cast<std::int64_t>(connectivity.size()))
        throw InputError({.file = in_.name()}, fmt::format("cell offset {} is out of order", offsets[i]));
      const std::size_t before = mesh_.tets.size();
      add_vtk_cell(
          mesh_, types[i],
          std::span(connectivity)
              .subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(offsets[i] - begin)),
          in_.name());
      if (mesh_.tets.size() > before) tet_of_cell[i] = static_cast<TetIndex>(before);
    }
    return tet_of_cell;
  }

  // tet_of_cell: no_tet for cells that are not tetrahedra.
  void take_labels(const VtkXmlPiece& piece, const std::vector<TetIndex>& tet_of_cell) {
    const auto section = piece.arrays.find("CellData");
    if (section == piece.arrays.end()) return;
    for (const auto& [name, array] : section->second) {
      const std::string type = array.attribute("type"), width = array.attribute("NumberOfComponents");
      const bool whole = type.starts_with("Int") || type.starts_with("UInt");
      if ((!whole && !type.starts_with("Float")) || (!width.empty() && width != "1") || name.empty())
        continue;
      std::vector<double> values;
      if (whole)
        for (const std::int64_t value : in_.integers(array)) values.push_back(static_cast<double>(value));
      else
        values = in_.reals(array);
      if (values.size() != tet_of_cell.size())
        throw InputError({.file = in_.name()}, fmt::format("cell array {:.40} has {} values, expected {}",
                                                           name, values.size(), tet_of_cell.size()));
      for (std::size_t i = 0; i < values.size(); ++i)
        if (tet_of_cell[i] != no_tet) labels_[name].push_back({tet_of_cell[i], values[i]});
    }
  }

  // Node groups: arrays of whole numbers in the point data that are 0 or 1.
  void take_masks(const VtkXmlPiece& piece, std::size_t first) {
    const auto section = piece.arrays.find("PointData");
    if (section == piece.arrays.end()) return;
    for (const auto& [name, array] : section->second) {
      const std::string type = array.attribute("type"), width = array.attribute("NumberOfComponents");
      const bool whole = type.starts_with("Int") || type.starts_with("UInt");
      if (!whole || (!width.empty() && width != "1") || name.empty()) continue;
      const std::vector<std::int64_t> values = in_.integers(array);
      const bool mask = std::ranges::all_of(values, [](std::int64_t v) { return v == 0 || v == 1; });
      if (!mask || values.size() != mesh_.nodes.size() - first) continue;
      for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] == 1) mesh_.groups[name].push_back(static_cast<NodeIndex>(first + i));
    }
  }

  VtkXmlReader in_;
  TetMesh mesh_;
  std::map<std::string, std::vector<CellLabel>> labels_;  // by cell array
};

}  // namespace

namespace {

template <class Index>
void put_masks(VtuWriter& out, const std::map<std::string, std::vector<Index>>& groups, std::size_t n) {
  for (const auto& [name, members] : groups) {
    std::vector<std::uint8_t> in(n, 0);
    for (const Index member : members) in[member] = 1;
    out.array<std::uint8_t>(name, 1, in);
  }
}

}  // namespace

void write_vtu(const std::filesystem::path& file, const TetMesh& mesh) {
  VtuWriter out(file, VtuData::text);
  out.begin(mesh.nodes.size(), mesh.tets.size());
  out.section("PointData");
  put_masks(out, mesh.groups, mesh.nodes.size());
  out.section("CellData");
  put_masks(out, mesh.element_groups, mesh.tets.size());
  out.points(mesh.nodes, "");
  out.cells(mesh.tets, vtk_cell::tetra);
  out.finish();
}

TetMesh read_vtu(Scanner in) {
  return VtuReader(std::move(in)).read();
}

}  // namespace forefeel
