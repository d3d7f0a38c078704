// Tetrahedra of label volumes: volumes, conforming interfaces, warnings.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/common/error.hpp"
#include "geometry/labels/label_mesh.hpp"
#include "tests/support/label_samples.hpp"

namespace forefeel {
namespace {

double sphere(double radius) {
  return 4.0 / 3 * M_PI * radius * radius * radius;
}

// Faces of the tetrahedra of a group that no other tetrahedron of it has.
std::vector<Triangle> boundary_of(const TetMesh& mesh, const std::vector<TetIndex>& group) {
  TetMesh part{.nodes = mesh.nodes, .tets = {}, .groups = {}};
  for (const TetIndex tet : group) part.tets.push_back(mesh.tets[static_cast<std::size_t>(tet)]);
  return boundary_triangles(part);
}

// Each edge of a closed surface has two triangles, once in each direction.
bool is_closed(const std::vector<Triangle>& triangles) {
  std::map<std::pair<NodeIndex, NodeIndex>, int> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const NodeIndex a = t[k], b = t[(k + 1) % 3];
      edges[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  return std::ranges::all_of(edges, [](const auto& edge) { return edge.second == 0; });
}

std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::ranges::sort(t);
  std::ranges::sort(triangles);
  return triangles;
}

TetMesh spheres(std::array<std::int64_t, 3> size, const Vec3& spacing, LabelMeshReport& report) {
  const LabelVolume volume = test::nested_spheres(size, spacing, 28, 14);
  return mesh_labels(volume, {.elements = 20'000, .labels = {{1, "shell"}, {7, "core"}}}, report);
}

}  // namespace

TEST_CASE("nested spheres keep their volumes within 1 %, with an interface that both share") {
  const auto [size, spacing] = GENERATE(std::pair(std::array<std::int64_t, 3>{64, 64, 64}, Vec3(1, 1, 1)),
                                        std::pair(std::array<std::int64_t, 3>{64, 64, 32}, Vec3(1, 1, 2)));
  LabelMeshReport report;
  TetMesh mesh = spheres(size, spacing, report);
  CHECK(mesh.tets.size() == Approx(20'000).epsilon(0.05));
  CHECK_NOTHROW(check_and_orient(mesh, "spheres"));
  REQUIRE(report.regions.size() == 2);
  CHECK(report.regions[0].mesh_volume == Approx(sphere(0.028) - sphere(0.014)).epsilon(0.01));
  CHECK(report.regions[1].mesh_volume == Approx(sphere(0.014)).epsilon(0.01));
  CHECK(report.regions[1].parts == 1);
  CHECK(report.hausdorff < 1e-3 * spacing.norm());  // a diagonal of a voxel
  CHECK(mesh_quality(mesh).min_dihedral_deg > 5);
  CHECK(report.warnings.empty());

  const std::vector<Triangle> core = boundary_of(mesh, mesh.element_groups.at("core")),
                              shell = boundary_of(mesh, mesh.element_groups.at("shell")),
                              outside = boundary_triangles(mesh);
  CHECK(is_closed(core));
  CHECK(is_closed(shell));
  CHECK(core.size() + outside.size() == shell.size());
  std::vector<Triangle> both = core;
  both.insert(both.end(), outside.begin(), outside.end());
  CHECK(sorted(both) == sorted(shell));
  for (const Triangle& t : core)
    for (const NodeIndex node : t)
      REQUIRE((mesh.nodes[static_cast<std::size_t>(node)] -
               1e-3 * 0.5 * Vec3(63, 63, spacing[2] * static_cast<double>(size[2] - 1)))
                  .norm() == Approx(0.014).margin(1.5e-3));
}

TEST_CASE("labels that are not there, at the border, or too small") {
  LabelVolume volume = test::nested_spheres({24, 24, 24}, {1, 1, 1}, 14, 6);
  LabelMeshReport report;
  try {
    mesh_labels(volume, {.labels = {{3, "liver"}}, .name = "v.nii"}, report);
    FAIL("label 3 is not there");
  } catch (const InputError& error) {
    CHECK(std::string(error.what()) == "v.nii: has no label 3, expected those it has: 1, 7");
  }
  volume.values.push_back(9);
  volume.voxels[volume.at(12, 12, 12)] = 3;
  const TetMesh mesh = mesh_labels(volume, {.elements = 3000}, report);
  CHECK(mesh.element_groups.contains("label_1"));
  CHECK(report.regions[0].touches_border);
  CHECK_FALSE(report.regions[1].touches_border);
  const auto said = [&](const std::string& words) {
    return std::ranges::any_of(report.warnings,
                               [&](const std::string& w) { return w.find(words) != std::string::npos; });
  };
  CHECK(said("label 1 (label_1) touches the border"));
  CHECK(said("label 9 (label_9) is a single voxel"));
  volume.voxels.assign(volume.voxels.size(), 0);
  volume.values = {0};
  CHECK_THROWS_AS(mesh_labels(volume, {}, report), InputError);
}

}  // namespace forefeel
