#include "geometry/mesh/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <vector>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"
#include "geometry/mesh/mesh_formats.hpp"

namespace forefeel {

namespace {

template <class Index>
void tidy(std::map<std::string, std::vector<Index>>& groups) {
  for (auto& [name, members] : groups) {
    std::ranges::sort(members);
    members.erase(std::unique(members.begin(), members.end()), members.end());
  }
  std::erase_if(groups, [](const auto& group) { return group.second.empty(); });
}

}  // namespace

const char* const not_tetrahedra =
    "expected tetrahedra; mesh the body again without recombined or extruded elements, or give `forefeel "
    "mesh` its "
    "surface with --elements";

void add_second_order(TetMesh& mesh, const Tet& corners, const std::array<NodeIndex, 6>& middle) {
  constexpr unsigned ends[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (std::size_t e = 0; e < 6; ++e) {
    const Vec3 &a = mesh.nodes[corners[ends[e][0]]], &b = mesh.nodes[corners[ends[e][1]]];
    if (const double length = (b - a).norm(); length > 0)
      mesh.second_order.bent =
          std::max(mesh.second_order.bent, (mesh.nodes[middle[e]] - 0.5 * (a + b)).norm() / length);
    mesh.second_order.middle_nodes.push_back(middle[e]);
  }
  mesh.tets.push_back(corners);
}

void tidy_groups(TetMesh& mesh) {
  std::vector<NodeIndex>& middle = mesh.second_order.middle_nodes;
  std::ranges::sort(middle);
  middle.erase(std::unique(middle.begin(), middle.end()), middle.end());
  tidy(mesh.groups);
  tidy(mesh.element_groups);
}

void add_label_groups(TetMesh& mesh, const std::string& array, std::span<const CellLabel> labels) {
  constexpr std::size_t most_labels = 256;
  std::map<std::int64_t, std::vector<TetIndex>> with;
  for (const CellLabel& label : labels) {
    if (!(std::abs(label.value) < 1e15) || label.value != std::floor(label.value)) return;
    with[static_cast<std::int64_t>(label.value)].push_back(label.tet);
    if (with.size() > most_labels) return;
  }
  const auto add = [&](const std::string& name, const std::vector<TetIndex>& tets) {
    auto& group = mesh.element_groups[name];
    group.insert(group.end(), tets.begin(), tets.end());
  };
  for (const auto& [value, tets] : with) add(fmt::format("{}_{}", array, value), tets);
  const bool mask = std::ranges::all_of(with, [](const auto& of) { return of.first == 0 || of.first == 1; });
  if (mask && with.contains(1)) add(array, with.at(1));
}

bool is_written_mesh(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".msh" || extension == ".vtu";
}

void write_mesh(const std::filesystem::path& file, const TetMesh& mesh) {
  if (!is_written_mesh(file))
    throw InputError({.file = file.string()}, "expected a name that ends in .msh or .vtu");
  lower_case(file.extension().string()) == ".vtu" ? write_vtu(file, mesh) : write_msh(file, mesh);
}

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".msh" || extension == ".vtk" || extension == ".vtu" || extension == ".mesh";
}

std::string converter_for(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  const std::string name = file.string();
  if (extension == ".feb") return "; FEBio Studio exports it as .vtk";
  if (extension == ".step" || extension == ".stp" || extension == ".iges" || extension == ".brep")
    return fmt::format("; gmsh -3 {} -o MESH.msh fills it", name);
  for (const std::string_view other :
       {".inp", ".bdf", ".nas", ".med", ".xdmf", ".e", ".exo", ".f3grid", ".avs", ".node", ".ele"})
    if (extension == other) return fmt::format("; meshio convert {} MESH.vtk converts it", name);
  return "";
}

TetMesh read_mesh(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (!is_mesh_file(file))
    throw InputError({.file = file.string()},
                     fmt::format("unknown kind of mesh '{}', expected .msh, .vtk, .vtu or .mesh{}", extension,
                                 converter_for(file)));
  Scanner in(read_file(file), file.string());
  TetMesh mesh = extension == ".msh"   ? read_gmsh(std::move(in))
                 : extension == ".vtk" ? read_vtk_legacy(std::move(in))
                 : extension == ".vtu" ? read_vtu(std::move(in))
                                       : read_medit(std::move(in));
  tidy_groups(mesh);
  return mesh;
}

namespace {

// Physical volume of each tetrahedron: from first_tag on in the order of the element groups; `rest` outside.
std::vector<int> volume_tags(const TetMesh& mesh, int first_tag, int rest) {
  std::vector<int> tags(mesh.tets.size(), rest);
  int tag = first_tag;
  for (const auto& [name, tets] : mesh.element_groups) {
    for (const TetIndex tet : tets)
      if (int& its = tags[tet]; its == rest) its = tag;
    ++tag;
  }
  return tags;
}

}  // namespace

void write_msh(const std::filesystem::path& file, const TetMesh& mesh) {
  fmt::memory_buffer text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
  // The node groups have tags 2, 3, … (dimension 0), the element groups those that follow (dimension 3). Without
  // element groups, all tetrahedra are in physical volume 1.
  const bool whole = mesh.element_groups.empty();
  std::map<std::string, std::vector<NodeIndex>> groups = mesh.groups;
  for (const auto& [name, tets] : mesh.element_groups) groups.erase(name);  // its nodes, read with it again
  const int first_volume = 2 + static_cast<int>(groups.size());
  const std::size_t names = groups.size() + mesh.element_groups.size();
  if (names > 0) {
    fmt::format_to(out, "$PhysicalNames\n{}\n", names + (whole ? 1 : 0));
    int tag = 2;
    for (const auto& [name, nodes] : groups) fmt::format_to(out, "0 {} \"{}\"\n", tag++, name);
    for (const auto& [name, tets] : mesh.element_groups) fmt::format_to(out, "3 {} \"{}\"\n", tag++, name);
    fmt::format_to(out, "{}$EndPhysicalNames\n", whole ? "3 1 \"body\"\n" : "");
  }
  fmt::format_to(out, "$Nodes\n{}\n", mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    fmt::format_to(out, "{} {} {} {}\n", i + 1, mesh.nodes[i].x(), mesh.nodes[i].y(), mesh.nodes[i].z());
  std::size_t elements = mesh.tets.size(), number = 1;
  for (const auto& [name, nodes] : groups) elements += nodes.size();
  fmt::format_to(out, "$EndNodes\n$Elements\n{}\n", elements);
  int tag = 2;
  for (const auto& [name, nodes] : groups) {
    for (const NodeIndex node : nodes)
      fmt::format_to(out, "{} 15 2 {} {} {}\n", number++, tag, tag, node + 1);
    ++tag;
  }
  const std::vector<int> volumes = volume_tags(mesh, first_volume, whole ? 1 : 0);
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    const Tet& t = mesh.tets[i];
    fmt::format_to(out, "{} 4 2 {} {} {} {} {} {}\n", number++, volumes[i], std::max(volumes[i], 1), t[0] + 1,
                   t[1] + 1, t[2] + 1, t[3] + 1);
  }
  fmt::format_to(out, "$EndElements\n");
  write_whole(file, {text.data(), text.size()});
}

}  // namespace forefeel
