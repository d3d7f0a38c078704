#include <Eigen/Geometry>

#include "geometry/mesh/tet_mesh.hpp"
#include "geometry/meshing/phantom.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

TetMesh regular_tet() {
  TetMesh m;
  m.nodes = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  m.tets = {{0, 2, 1, 3}};
  check_and_orient(m, "regular");
  return m;
}

}  // namespace

TEST_CASE("volume and dihedral angles of known tetrahedra") {
  const MeshQuality regular = mesh_quality(regular_tet());
  CHECK(regular.volume == Approx(std::pow(8, 1.5) / (6 * std::sqrt(2.0))).epsilon(1e-14));
  CHECK(regular.min_dihedral_deg == Approx(std::acos(1.0 / 3) * 180 / std::numbers::pi).epsilon(1e-13));
  CHECK(regular.max_dihedral_deg == Approx(regular.min_dihedral_deg).epsilon(1e-13));
  TetMesh corner;
  corner.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.tets = {{0, 1, 2, 3}};
  CHECK(tet_volume(corner, 0) == Approx(1.0 / 6).epsilon(1e-15));
  CHECK(mesh_quality(corner).max_dihedral_deg == Approx(90).epsilon(1e-13));
  CHECK(mesh_quality(corner).min_dihedral_deg ==
        Approx(std::atan(std::sqrt(2.0)) * 180 / std::numbers::pi).epsilon(1e-13));
}

TEST_CASE("boundary triangles close the body and face outward") {
  for (const char* name : {"beam", "ball", "liver"}) {
    INFO(name);
    const TetMesh mesh = phantom(name, 400);
    const std::vector<Triangle> triangles = boundary_triangles(mesh);
    Vec3 area = Vec3::Zero();
    double volume = 0;
    std::set<std::pair<NodeIndex, NodeIndex>> edges;
    for (const auto& [a, b, c] : triangles) {
      const Vec3 &p = mesh.nodes[std::size_t(a)], &q = mesh.nodes[std::size_t(b)],
                 &r = mesh.nodes[std::size_t(c)];
      area += (q - p).cross(r - p) / 2;
      volume += p.dot(q.cross(r)) / 6;
      for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
        CHECK(edges.insert(edge).second);
    }
    for (const auto& [a, b] : edges) CHECK(edges.contains({b, a}));
    CHECK(area.norm() < 1e-15);
    CHECK(volume == Approx(mesh_quality(mesh).volume).epsilon(1e-12));
  }
}

TEST_CASE("a mesh is turned with a warning, or refused") {
  const TetMesh good = test::sample_mesh();
  TetMesh mesh = good;
  CHECK(check_and_orient(mesh, "good").warnings.empty());

  for (Tet& tet : mesh.tets) std::swap(tet[0], tet[1]);
  const MeshCheck turned = check_and_orient(mesh, "turned");
  REQUIRE(turned.warnings.size() == 1);
  CHECK(turned.warnings[0].find("all tetrahedra were turned") == 0);
  CHECK(mesh_quality(mesh).min_tet_volume > 0);

  const auto refused = [&](auto&& change, const char* line) {
    TetMesh bad = good;
    change(bad);
    CHECK_THROWS_WITH(check_and_orient(bad, "f.msh"), Contains("f.msh: ", line));
  };
  refused([](TetMesh& m) { m.tets.clear(); }, "no tetrahedra");
  refused([](TetMesh& m) { m.tets[1][0] = m.tets[1][1]; }, "tetrahedron 1 (from 0");
  refused([](TetMesh& m) { m.nodes[4] = (m.nodes[1] + m.nodes[2] + m.nodes[3]) / 3; }, "zero volume");
  refused([](TetMesh& m) { m.tets[2][3] = 6; }, "names node 6, expected 0 to 5");
  refused([](TetMesh& m) { m.tets[2][3] = -1; }, "names node -1");
  refused([](TetMesh& m) { m.nodes[3].y() = INFINITY; }, "not finite");
  refused([](TetMesh& m) { m.nodes[4] = m.nodes[0] - Vec3(0.1, 0.1, 0.1); }, "overlap");

  TetMesh apart = good;
  for (int k = 0; k < 4; ++k) apart.nodes.push_back(good.nodes[std::size_t(k)] + Vec3(5, 0, 0));
  apart.tets.push_back({6, 7, 8, 9});
  apart.nodes.emplace_back(9, 9, 9);
  const MeshCheck check = check_and_orient(apart, "apart");
  REQUIRE(check.warnings.size() == 2);
  CHECK(check.warnings[0] == "1 node belongs to no tetrahedron and is no part of the body");
  CHECK(check.warnings[1] == "the mesh has 2 parts that do not hang together");
  CHECK(components(apart) == std::vector<int>{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, -1});
}

TEST_CASE("checks do not depend on the unit of length") {
  for (const double unit : {1e-3, 1.0, 1e6}) {
    TetMesh mesh = test::sample_mesh();
    for (Vec3& node : mesh.nodes) node *= unit;
    CHECK(check_and_orient(mesh, "scaled").warnings.empty());
    scale_to_length(mesh, 0.22);
    CHECK(longest_side(mesh) == Approx(0.22).epsilon(1e-14));
  }
}

TEST_CASE("node sets by geometry") {
  const TetMesh beam = phantom("beam");
  const std::vector<NodeIndex> root = nodes_below(beam, Axis::x, 0.051);
  CHECK(root.size() == 50);  // two of 21 layers of 25
  for (const NodeIndex node : root) CHECK(beam.nodes[std::size_t(node)].x() <= 0.1 * 0.051);
  const Vec3 tip(0.1, 0.01, 0.01);
  const NodeIndex nearest = nearest_surface_node(beam, tip);
  CHECK((beam.nodes[std::size_t(nearest)] - tip).norm() < 1e-12);
  for (const NodeIndex node : surface_nodes_within(beam, tip, 0.006))
    CHECK((beam.nodes[std::size_t(node)] - tip).norm() <= 0.006);
  CHECK(surface_nodes_within(beam, tip, 0.0051).size() == 5);
}
