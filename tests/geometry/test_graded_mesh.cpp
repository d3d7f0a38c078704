// Meshes graded toward a contact, and edges along the rim of the clamp.

#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/size_field.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

// Mean over the edges of the boundary whose middle lies between two distances of a site, of length over wanted length.
double stretch(const TetMesh& mesh, const SizeField& size, double from, double to) {
  double sum = 0;
  std::size_t count = 0;
  for (const Triangle& t : boundary_triangles(mesh))
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = mesh.nodes[t[k]], &b = mesh.nodes[t[(k + 1) % 3]], middle = (a + b) / 2;
      const double distance = (middle - size.site).norm();
      if (distance >= from && distance < to) sum += (a - b).norm() / size.at(middle), ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

double area_of_group(const TetMesh& mesh, const std::vector<NodeIndex>& group) {
  double sum = 0;
  for (const Triangle& t : boundary_triangles(mesh))
    if (std::ranges::all_of(t, [&](NodeIndex node) { return std::ranges::binary_search(group, node); }))
      sum += (mesh.nodes[t[1]] - mesh.nodes[t[0]]).cross(mesh.nodes[t[2]] - mesh.nodes[t[0]]).norm() / 2;
  return sum;
}

}  // namespace

TEST_CASE("a graded phantom has the wanted number, edges near the wanted ones, and good shapes",
          SLOW("makes graded meshes of all phantoms")) {
  for (const auto& [name, radius] :
       {std::pair("liver", 0.02), std::pair("ball", 0.02), std::pair("slab", 0.02), std::pair("beam", 0.008)})
    for (const std::size_t elements : {1800ul, 6000ul}) {
      INFO(name << " " << elements);
      SizeField size;
      const TetMesh made =
          graded_phantom(name, {.elements = elements, .toward = {phantom_tip(name), radius}}, &size);
      TetMesh mesh = made;
      CHECK(double(mesh.tets.size()) == Approx(double(elements)).epsilon(0.05));
      CHECK(check_and_orient(mesh, name).warnings.empty());
      CHECK(mesh_quality(mesh).min_dihedral_deg > 12);
      CHECK(size.near < 0.7 * size.far);
      // Triangles are somewhat smaller than the faces of tetrahedra of the wanted volume, near the contact most.
      CHECK(stretch(mesh, size, 0, radius) == Approx(0.85).margin(0.2));
      CHECK(stretch(mesh, size, radius, 1) == Approx(0.95).margin(0.2));
      const TetMesh again =
          graded_phantom(name, {.elements = elements, .toward = {phantom_tip(name), radius}});
      CHECK(again.nodes == made.nodes);
      CHECK(again.tets == made.tets);
    }
}

TEST_CASE("nodes of a graded phantom lie on its exact surface") {
  const TetMesh ball = graded_phantom("ball", {.elements = 2000, .toward = {{0, 0.05, 0}, 0.01}});
  double worst = 0;
  for (const NodeIndex node : surface_nodes(ball))
    worst = std::max(worst, std::abs(ball.nodes[node].norm() - 0.05));
  CHECK(worst < 1e-12);
  const TetMesh slab = graded_phantom("slab", {.elements = 3000, .toward = {{0, 0, 0.04}, 0.02}});
  CHECK(mesh_quality(slab).volume == Approx(1.6e-3).epsilon(1e-6));
}

TEST_CASE("the clamped area of a graded ball tends to that of the cap, by the square of the edge") {
  // Cap of height 0.2 of the diameter: 2 pi R h.
  const double exact = 2 * std::numbers::pi * 0.05 * 0.02;
  std::vector<double> errors;
  for (const std::size_t elements : {1000ul, 8000ul, 64000ul}) {
    const TetMesh mesh = graded_phantom("ball", {.elements = elements, .toward = {{0, 0, 0.05}, 0.02}});
    errors.push_back(1 - area_of_group(mesh, mesh.groups.at("clamp")) / exact);
  }
  CAPTURE(errors[0], errors[1], errors[2]);
  CHECK(errors[0] < 0.08);
  CHECK(errors[1] < 0.02);
  CHECK(errors[2] < 0.005);
  CHECK(errors[2] > 0);
}

TEST_CASE(
    "a clamp's rim of a scene is an edge of a meshed surface: the area below it is exact on flat faces") {
  Surface cube = test::unit_cube();
  for (const std::size_t elements : {500ul, 2000ul, 8000ul}) {
    const TetMesh mesh = tetrahedralise(
        cube, {.elements = elements, .toward = Toward{{0.5, 0.5, 1}, 0.2}, .rim = LowEnd{Axis::z, 0.3}});
    CHECK(double(mesh.tets.size()) == Approx(double(elements)).epsilon(0.05));
    const std::vector<NodeIndex> clamp = nodes_below(mesh, Axis::z, 0.3);
    CHECK(area_of_group(mesh, clamp) == Approx(1 + 4 * 0.3).epsilon(1e-9));
    CHECK(mesh_quality(mesh).volume == Approx(1).epsilon(1e-9));
    CHECK(mesh_quality(mesh).min_dihedral_deg > 10);
  }
}

TEST_CASE("the size field counts the tetrahedra it gives") {
  const Surface ball = phantom_surface("ball");
  // Even: N h^3 0.15 = V.
  const double edge = uniform_edge(ball, 2000);
  CHECK(2000 * 0.15 * edge * edge * edge == Approx(enclosed_volume(ball)).epsilon(1e-12));
  const SizeField size = size_field(ball, {{0, 0, 0.05}, 0.01}, 5000);
  CHECK(size.near > 0);
  CHECK(size.near <= uniform_edge(ball, 5000));
  CHECK(size.at({0, 0, 0.045}) == size.near);
  CHECK(size.at({0, 0, 0.03}) == Approx(std::min(size.far, size.near + 0.4 * 0.01)));
  // The integral over the ball on a fine grid.
  double sum = 0;
  const int n = 100;
  const double step = 0.1 / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Vec3 y = Vec3(i + 0.5, j + 0.5, k + 0.5) * step - Vec3::Constant(0.05);
        if (y.norm() < 0.05) sum += step * step * step / (0.15 * std::pow(size.at(y), 3));
      }
  CHECK(sum == Approx(5000).epsilon(0.04));  // the polyhedron has 2 % less volume than the ball
  // A contact as large as the body: even.
  const SizeField whole = size_field(ball, {{0, 0, 0.05}, 0.2}, 5000);
  CHECK(whole.near == Approx(uniform_edge(ball, 5000)).epsilon(1e-3));
}

TEST_CASE("a graded mesh is refused in words") {
  const Surface cube = test::unit_cube();
  CHECK_THAT(error_of([&] {
               tetrahedralise(cube, {.name = "cube", .toward = Toward{{0, 0, 1}, 0.1}});
             }),
             Contains("cube", "number of elements"));
  CHECK_THAT(error_of([&] {
               tetrahedralise(cube, {.elements = 500, .name = "cube", .toward = Toward{{0, 0, 1}, 0}});
             }),
             Contains("radius", "positive"));
  CHECK_THAT(error_of([&] {
               graded_phantom("ball", {.toward = {{0, 0, 1}, -1}});
             }),
             Contains("radius", "positive"));
}
