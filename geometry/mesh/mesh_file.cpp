#include "geometry/mesh/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/mesh/mesh_formats.hpp"

namespace forefeel {

void tidy_groups(TetMesh& mesh) {
  for (auto& [name, nodes] : mesh.groups) {
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
  std::erase_if(mesh.groups, [](const auto& group) { return group.second.empty(); });
}

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".msh" || extension == ".vtk" || extension == ".vtu" || extension == ".mesh";
}

TetMesh read_mesh(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (!is_mesh_file(file))
    throw InputError({.file = file.string()},
                     fmt::format("unknown kind of mesh '{}', expected .msh, .vtk, .vtu or .mesh", extension));
  Scanner in(read_file(file), file.string());
  TetMesh mesh = extension == ".msh"   ? read_gmsh(std::move(in))
                 : extension == ".vtk" ? read_vtk_legacy(std::move(in))
                 : extension == ".vtu" ? read_vtu(std::move(in))
                                       : read_medit(std::move(in));
  tidy_groups(mesh);
  return mesh;
}

void write_msh(const std::filesystem::path& file, const TetMesh& mesh) {
  fmt::memory_buffer text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
  // Physical group 1 holds the tetrahedra (dimension 3), groups 2, 3, … the node groups (dimension 0).
  if (!mesh.groups.empty()) {
    fmt::format_to(out, "$PhysicalNames\n{}\n", mesh.groups.size() + 1);
    int tag = 2;
    for (const auto& [name, nodes] : mesh.groups) fmt::format_to(out, "0 {} \"{}\"\n", tag++, name);
    fmt::format_to(out, "3 1 \"body\"\n$EndPhysicalNames\n");
  }
  fmt::format_to(out, "$Nodes\n{}\n", mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    fmt::format_to(out, "{} {} {} {}\n", i + 1, mesh.nodes[i].x(), mesh.nodes[i].y(), mesh.nodes[i].z());
  std::size_t elements = mesh.tets.size(), number = 1;
  for (const auto& [name, nodes] : mesh.groups) elements += nodes.size();
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", elements);
  int tag = 2;
  for (const auto& [name, nodes] : mesh.groups) {
    for (const NodeIndex node : nodes)
      fmt::format_to(out, "{} 15 2 {} {} {}\n", number++, tag, tag, node + 1);
    ++tag;
  }
  for (const Tet& t : mesh.tets)
    fmt::format_to(out, "{} 4 2 1 1 {} {} {} {}\n", number++, t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  fmt::format_to(out, "$EndElements\n");
  OutputFile output(file);
  output.write({text.data(), text.size()});
  output.commit();
}

}  // namespace forefeel
