// Legacy .vtk, DATASET UNSTRUCTURED_GRID (vtk_legacy.hpp). Points, lines and faces among the cells are passed over;
// other volume cells are refused. Arrays of CELL_DATA that label the tetrahedra become element groups.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "geometry/common/error.hpp"
#include "geometry/mesh/mesh_formats.hpp"
#include "geometry/mesh/vtk_legacy.hpp"

namespace forefeel {

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

}  // namespace forefeel
