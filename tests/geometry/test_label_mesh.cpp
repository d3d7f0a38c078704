// Tetrahedra of label volumes: volumes, conforming interfaces, warnings.

#include "geometry/segmentation/label_domain.hpp"
#include "geometry/segmentation/label_mesh.hpp"
#include "tests/support/label_samples.hpp"
#include "tests/support/test.hpp"

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

TEST_CASE("nested spheres keep their volumes within 1 %, with an interface that both share",
          SLOW("makes fine meshes of label volumes")) {
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

TEST_CASE("two labels of an atlas with hundreds of them; without a choice it is refused") {
  LabelVolume atlas = test::nested_spheres({24, 24, 24}, {1, 1, 1}, 10, 5);
  for (int v = 0; v < 700; ++v) atlas.values.push_back(100 + v);
  for (std::size_t v = 0; v < 700; ++v) atlas.voxels[v] = static_cast<std::uint16_t>(3 + v);  // in a corner
  LabelMeshReport report;
  CHECK_THAT(error_of([&] { mesh_labels(atlas, {.elements = 2000, .name = "atlas.nii"}, report); }),
             Contains("atlas.nii: holds 703 different values, expected at most 255", "--labels that choose",
                      "(702 in all)"));
  const TetMesh mesh = mesh_labels(atlas, {.elements = 2000, .labels = {{1, "shell"}, {7, "core"}}}, report);
  CHECK(mesh.tets.size() == Approx(2000).epsilon(0.05));
  REQUIRE(report.regions.size() == 2);
  CHECK(report.regions[1].mesh_volume == Approx(sphere(0.005)).epsilon(0.1));
}

// A sheet of two voxels, waved: it is found everywhere, at sizes below and above its thickness.
TEST_CASE("a thin sheet gets the number of elements that is asked for",
          SLOW("makes fine meshes of label volumes")) {
  LabelVolume volume;
  volume.size = {64, 64, 32};
  volume.axes = 1e-3 * Mat3::Identity();
  volume.values = {0, 1};
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i) {
        const double height = 16 + 5 * std::sin(i / 10.0) * std::cos(j / 8.0);
        const bool inside = std::min(i, j) > 3 && std::max(i, j) < 60 && std::abs(k - height) < 1;
        volume.voxels.push_back(inside ? 1 : 0);
      }
  for (const std::size_t elements : {4000, 12'000}) {
    LabelMeshReport report;
    TetMesh mesh = mesh_labels(volume, {.elements = elements}, report);
    CHECK(mesh.tets.size() == Approx(elements).epsilon(0.05));
    CHECK_NOTHROW(check_and_orient(mesh, "sheet"));
  }
}

TEST_CASE("flat tetrahedra are opened without a change of labels or neighbours") {
  // Two cells of five tetrahedra each, one subdomain each, with a node in the first moved into one of its faces.
  LabelledTets mesh;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) mesh.nodes.push_back(0.01 * Vec3(i, j, k));
  const auto at = [](int i, int j, int k) { return 4 * i + 2 * j + k; };
  const auto inner = static_cast<NodeIndex>(mesh.nodes.size());
  mesh.nodes.push_back(0.01 * Vec3(0.5, 0.5, 1e-13));
  const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                           {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& [a, b, c, d] : faces) {
    const auto node = [&](int corner) {
      return static_cast<NodeIndex>(at(corner >> 2, corner >> 1 & 1, corner & 1));
    };
    mesh.tets.push_back({node(a), node(b), node(c), inner}), mesh.subdomain.push_back(1);
    mesh.tets.push_back({node(a), node(c), node(d), inner}), mesh.subdomain.push_back(1);
  }
  mesh.tets.push_back({at(1, 0, 0), at(2, 0, 0), at(1, 1, 0), at(1, 0, 1)}), mesh.subdomain.push_back(2);
  REQUIRE(has_flat_tets(mesh));
  const LabelledTets before = mesh;
  mend_slivers(mesh);
  CHECK_FALSE(has_flat_tets(mesh));
  CHECK(mesh.subdomain == before.subdomain);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Tet was = before.tets[t], is = mesh.tets[t];
    std::ranges::sort(was), std::ranges::sort(is);
    CHECK(was == is);
  }
  for (NodeIndex node = 0; node < inner; ++node)  // on the interface or the boundary: not far
    CHECK((mesh.nodes[static_cast<std::size_t>(node)] - before.nodes[static_cast<std::size_t>(node)]).norm() <
          1e-3);
  TetMesh body{.nodes = mesh.nodes, .tets = mesh.tets, .groups = {}};
  CHECK(mesh_quality(body).min_dihedral_deg > 10);
}
