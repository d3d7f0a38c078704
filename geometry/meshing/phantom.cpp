#include "geometry/meshing/phantom.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/common/error.hpp"
#include "geometry/meshing/relax.hpp"
#include "geometry/meshing/tet_fill.hpp"

namespace forefeel {
namespace {

constexpr double patch_radius = 0.02;  // of the group "contact" [m]

// Two blended ellipsoids, whose semi-axes r differ above and below the equator:
//   g_i = |(x - c_i) / r_i|^2,   f = 1 / g_1^2 + 1 / g_2^2 - 1
// The right lobe (x < 0) is thick, the left one thin; the underside is flat.
struct Lobe {
  Vec3 centre;
  double x, y, above, below;  // semi-axes [m]

  Vec3 weights(const Vec3& p) const {
    const double z = p.z() > centre.z() ? above : below;
    return {1 / (x * x), 1 / (y * y), 1 / (z * z)};
  }
  double form(const Vec3& p) const { return weights(p).dot((p - centre).cwiseAbs2()); }
  Vec3 form_gradient(const Vec3& p) const { return 2 * weights(p).cwiseProduct(p - centre); }
};

const std::array<Lobe, 2>& lobes() {
  static const std::array<Lobe, 2> both{Lobe{{-0.0425, 0, 0}, 0.0665, 0.062, 0.060, 0.036},
                                        Lobe{{0.0475, 0.012, -0.004}, 0.0595, 0.045, 0.032, 0.026}};
  return both;
}

ImplicitSurface liver_body() {
  const auto value = [](const Vec3& p) {
    double sum = -1;
    for (const Lobe& lobe : lobes()) {
      const double g = lobe.form(p);
      sum += 1 / (g * g);
    }
    return sum;
  };
  const auto gradient = [](const Vec3& p) {
    Vec3 sum = Vec3::Zero();
    for (const Lobe& lobe : lobes()) {
      const double g = lobe.form(p);
      sum += -2 / (g * g * g) * lobe.form_gradient(p);
    }
    return sum;
  };
  return {value, gradient, Vec3(0.006, 0.004, 0), 0.2};
}

// Farthest point of the body along a direction, by ascent along the surface.
Vec3 extreme(const ImplicitSurface& body, const Vec3& direction) {
  Vec3 point = last_crossing(body, body.centre, direction);
  for (int k = 0; k < 200; ++k) {
    const Vec3 normal = body.gradient(point).normalized();
    point = project_onto(body, point + 0.02 * (direction - normal.dot(direction) * normal));
  }
  return point;
}

// The body scaled to its length of 22 cm, and the points that every triangulation of it holds.
struct Liver {
  ImplicitSurface unscaled = liver_body();
  Vec3 left = extreme(unscaled, -Vec3::UnitX()), right = extreme(unscaled, Vec3::UnitX());
  Vec3 top = last_crossing(unscaled, lobes()[0].centre, Vec3::UnitZ());  // above the thickest place
  double scale = 0.22 / (right.x() - left.x());

  Surface surface(int n) const {
    Surface result = triangulate_implicit(unscaled, n, std::array{top, left, right});
    for (Vec3& node : result.nodes) node *= scale;
    return result;
  }
};

const Liver& liver() {
  static const Liver body;
  return body;
}

struct Blueprint {
  std::string_view name;
  std::size_t elements;  // default
  Vec3 tip;
};

const std::array<Blueprint, 4>& blueprints() {
  static const std::array<Blueprint, 4> all{
      Blueprint{"liver", 1777, liver().scale * liver().top}, Blueprint{"beam", 1920, {0.1, 0.01, 0.01}},
      Blueprint{"ball", 2000, {0, 0, 0.05}}, Blueprint{"slab", 3000, {0, 0, 0.04}}};
  return all;
}

const Blueprint& blueprint(std::string_view name) {
  for (const Blueprint& known : blueprints())
    if (known.name == name) return known;
  throw InputError(
      "phantom", fmt::format("'{}' is unknown, expected one of {}", name, fmt::join(phantom_names(), ", ")));
}

bool within_share(std::size_t count, std::size_t asked) {
  return std::abs(static_cast<double>(count) - static_cast<double>(asked)) <
         0.0499 * static_cast<double>(asked);
}

Surface smooth_surface(std::string_view name, int n) {
  if (name == "ball") {
    Surface sphere = geodesic_sphere(n);
    for (Vec3& node : sphere.nodes) node *= 0.05;
    return sphere;
  }
  return liver().surface(n);
}

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

Box box_of(std::string_view name) {
  return name == "beam" ? Box{{0, 0, 0}, {0.1, 0.02, 0.02}} : Box{{-0.1, -0.1, 0}, {0.1, 0.1, 0.04}};
}

bool is_box(std::string_view name) {
  return name == "beam" || name == "slab";
}

// The subdivision n whose triangles are about as large as the faces of `elements` equal tetrahedra in the
// body.
int frequency_for(std::size_t elements) {
  return std::max(1, static_cast<int>(std::lround(5 * std::cbrt(static_cast<double>(elements) / 1777))));
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

std::vector<std::string> phantom_names() {
  std::vector<std::string> names;
  for (const Blueprint& known : blueprints()) names.emplace_back(known.name);
  return names;
}

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
  contact = surface_nodes_within(mesh, known.tip, name == "beam" ? patch_radius / 2 : patch_radius);
  if (contact.empty()) contact = {nearest_surface_node(mesh, known.tip)};  // a mesh coarser than the patch
  return mesh;
}

Vec3 phantom_tip(std::string_view name) {
  return blueprint(name).tip;
}

}  // namespace forefeel
