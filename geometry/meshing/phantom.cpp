#include "geometry/meshing/phantom.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/meshing/phantom_bodies.hpp"
#include "geometry/meshing/relax.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

// A regular box mesh: cells cut into six tetrahedra along their diagonal (Kuhn), conforming as it stands.
TetMesh box_mesh(const Box& box, const std::array<int, 3>& cells) {
  TetMesh mesh;
  const auto at = [&](int i, int j, int k) {
    return static_cast<NodeIndex>((k * (cells[1] + 1) + j) * (cells[0] + 1) + i);
  };
  for (int k = 0; k <= cells[2]; ++k)
    for (int j = 0; j <= cells[1]; ++j)
      for (int i = 0; i <= cells[0]; ++i)
        mesh.nodes.emplace_back(
            box.low +
            Vec3(double(i) / cells[0], double(j) / cells[1], double(k) / cells[2]).cwiseProduct(box.size()));
  constexpr unsigned orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};  // first three even
  for (int k = 0; k < cells[2]; ++k)
    for (int j = 0; j < cells[1]; ++j)
      for (int i = 0; i < cells[0]; ++i)
        for (int o = 0; o < 6; ++o) {
          std::array<int, 3> corner{i, j, k};
          Tet tet{at(i, j, k), 0, 0, 0};
          for (unsigned s = 0; s < 3; ++s) {
            ++corner[orders[o][s]];
            tet[s + 1] = at(corner[0], corner[1], corner[2]);
          }
          if (o >= 3) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
  return mesh;
}

// Cell counts with 6 n_x n_y n_z within 5 % of the wanted number, and cells as near to cubes as possible.
std::array<int, 3> cells_for(const Vec3& size, std::size_t elements) {
  const double cells = static_cast<double>(elements) / 6;
  const double edge = std::cbrt(size.prod() / cells);
  std::array<int, 3> best{};
  double least = 1e300;
  const auto reach = [&](int axis) { return static_cast<int>(2 * size[axis] / edge) + 2; };
  for (int i = 1; i <= reach(0); ++i)
    for (int j = 1; j <= reach(1); ++j) {
      const int k = std::max(1, static_cast<int>(std::lround(cells / i / j)));
      const auto count = static_cast<std::size_t>(6) * static_cast<std::size_t>(i) *
                         static_cast<std::size_t>(j) * static_cast<std::size_t>(k);
      if (!within_share(count, elements)) continue;
      const Vec3 sides(size.x() / i, size.y() / j, size.z() / k);
      // Cost of aspect ratio and count: a deviation of 2 % in the count weighs as much as an elongation of 2 %.
      const double cost =
          sides.maxCoeff() / sides.minCoeff() + std::abs(static_cast<double>(count) / (6 * cells) - 1);
      if (cost < least) least = cost, best = {i, j, k};
    }
  if (best[0] == 0)
    throw InputError(
        "phantom", fmt::format("{} elements cannot be met within 5 % by a grid, expected about {}", elements,
                               6 * std::max(1L, std::lround(cells))));
  return best;
}

TetMesh smooth_mesh(std::string_view name, std::size_t elements) {
  std::string problem;
  for (int n = frequency_for(elements); n >= 1; --n) {
    CountedFill fill = fill_to_count(smooth_surface(name, n), elements, 0.02);
    if (fill.mesh && within_share(fill.mesh->tets.size(), elements)) return std::move(*fill.mesh);
    problem = fill.problem;
    if (!fill.mesh) break;
  }
  throw InputError("phantom", fmt::format("{} elements cannot be met within 5 %{}{}", elements,
                                          problem.empty() ? "" : ": ", problem));
}

// The clamp: beam at its root, ball and slab below, liver on its underside.
std::vector<NodeIndex> clamp_nodes(std::string_view name, const TetMesh& mesh) {
  if (name == "beam") return nodes_below(mesh, Axis::x, 1e-9);
  if (name == "slab") return nodes_below(mesh, Axis::z, 1e-9);
  std::vector<NodeIndex> result, surface = surface_nodes(mesh);
  for (const NodeIndex node : nodes_below(mesh, Axis::z, name == "ball" ? 0.2 : 0.25))
    if (std::ranges::binary_search(surface, node)) result.push_back(node);
  return result;
}

}  // namespace

Surface phantom_surface(std::string_view name) {
  const Blueprint& known = blueprint(name);
  if (!is_box(name)) return smooth_surface(name, frequency_for(known.elements));
  const TetMesh mesh = box_mesh(box_of(name), cells_for(box_of(name).size(), known.elements));
  return boundary_surface(mesh);
}

TetMesh phantom(std::string_view name, std::size_t elements) {
  const Blueprint& known = blueprint(name);
  if (elements == 0) elements = known.elements;
  TetMesh mesh = is_box(name) ? box_mesh(box_of(name), cells_for(box_of(name).size(), elements))
                              : smooth_mesh(name, elements);
  mesh.groups["clamp"] = clamp_nodes(name, mesh);
  auto& contact = mesh.groups["contact"];
  contact = surface_nodes_within(mesh, known.tip, phantom_patch(name));
  if (contact.empty()) contact = {nearest_surface_node(mesh, known.tip)};  // a mesh coarser than the patch
  mark_lump(name, mesh);
  return mesh;
}

std::vector<std::string> phantom_names() {
  return blueprint_names();
}

Vec3 phantom_tip(std::string_view name) {
  return blueprint(name).tip;
}

}  // namespace forefeel
