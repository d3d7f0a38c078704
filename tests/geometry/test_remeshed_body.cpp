// Volume meshes made finer: split in eight, or made anew from their boundary, with their groups.

#include "geometry/mesh/subdivided_mesh.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/remeshed_body.hpp"
#include "tests/support/test.hpp"

namespace {

double area_of_group(const TetMesh& mesh, const std::string& group) {
  const std::vector<NodeIndex>& nodes = mesh.groups.at(group);
  double sum = 0;
  for (const Triangle& t : boundary_triangles(mesh))
    if (std::ranges::all_of(t, [&](NodeIndex node) { return std::ranges::binary_search(nodes, node); }))
      sum += (mesh.nodes[t[1]] - mesh.nodes[t[0]]).cross(mesh.nodes[t[2]] - mesh.nodes[t[0]]).norm() / 2;
  return sum;
}

}  // namespace

TEST_CASE("a mesh split in eight keeps volume, boundary and groups") {
  TetMesh mesh = phantom("liver", 900);
  mesh.element_groups["some"] = {0, 5, 17};
  double some = 0;
  for (const TetIndex t : mesh.element_groups["some"]) some += tet_volume(mesh, t);
  TetMesh fine = subdivided(mesh);
  CHECK(fine.tets.size() == 8 * mesh.tets.size());
  CHECK(check_and_orient(fine, "fine").warnings.empty());
  CHECK(mesh_quality(fine).volume == Approx(mesh_quality(mesh).volume).epsilon(1e-12));
  CHECK(boundary_triangles(fine).size() == 4 * boundary_triangles(mesh).size());
  CHECK(area_of_group(fine, "clamp") == Approx(area_of_group(mesh, "clamp")).epsilon(1e-12));
  double sum = 0;
  for (const TetIndex t : fine.element_groups.at("some")) sum += tet_volume(fine, t);
  CHECK(sum == Approx(some).epsilon(1e-12));
}

TEST_CASE("a volume mesh made anew keeps its groups of surface nodes, graded or even",
          SLOW("makes four meshes")) {
  for (const char* name : {"beam", "slab", "ball"}) {
    INFO(name);
    TetMesh mesh = phantom(name, 1500);
    mesh.element_groups.erase("lump");  // the slab's is refused, see below
    const NodeIndex single = nearest_surface_node(mesh, bounding_box(mesh).high);
    mesh.groups["single"] = {single};
    mesh.element_groups["all"].resize(mesh.tets.size());
    for (TetIndex t = 0; t < mesh.tets.size(); ++t) mesh.element_groups["all"][t] = t;
    for (const bool graded : {false, true}) {
      TetrahedraliseOptions options{.elements = 6000, .name = name};
      if (graded) options.toward = Toward{phantom_tip(name), 0.01};
      TetrahedraliseReport report;
      TetMesh fine = remeshed(mesh, options, &report);
      CHECK(double(fine.tets.size()) == Approx(6000).epsilon(0.05));
      CHECK(check_and_orient(fine, name).warnings.empty());
      CHECK(mesh_quality(fine).min_dihedral_deg > 8);
      // The border follows the old edges. Inside it, new triangles cut the edges of a round body's old surface.
      const double tolerance = std::string(name) == "ball" ? 0.01 : 1e-6;
      CHECK(area_of_group(fine, "clamp") == Approx(area_of_group(mesh, "clamp")).epsilon(tolerance));
      CHECK(area_of_group(fine, "contact") == Approx(area_of_group(mesh, "contact")).epsilon(tolerance));
      REQUIRE(fine.groups.at("single").size() == 1);
      CHECK((fine.nodes[fine.groups.at("single")[0]] - mesh.nodes[single]).norm() < 1e-9);
      CHECK(fine.element_groups.at("all").size() == fine.tets.size());
    }
  }
}

TEST_CASE("groups that a mesh of the boundary cannot keep are refused with the reason") {
  TetMesh mesh = phantom("slab", 1500);
  const std::vector<TetIndex> some = std::exchange(mesh.element_groups, {}).at("lump");
  const auto refusal = [&](const TetMesh& body) {
    return error_of([&] { remeshed(body, {.elements = 3000, .name = "slab.msh"}); });
  };
  TetMesh inner = mesh;
  const std::vector<NodeIndex> surface = surface_nodes(mesh);
  for (NodeIndex node = 0; node < mesh.nodes.size() && inner.groups["deep"].empty(); ++node)
    if (!std::ranges::binary_search(surface, node)) inner.groups["deep"] = {node};
  CHECK_THAT(refusal(inner), Contains("slab.msh", "'deep'", "nodes inside the body"));
  TetMesh line = mesh;
  const Triangle edge = boundary_triangles(mesh).front();
  line.groups["edge"] = {std::min(edge[0], edge[1]), std::max(edge[0], edge[1])};
  CHECK_THAT(refusal(line), Contains("'edge'", "in a line"));
  TetMesh lump = mesh;
  lump.element_groups["lump"] = some;
  CHECK_THAT(refusal(lump), Contains("'lump'", "border inside it"));
}
