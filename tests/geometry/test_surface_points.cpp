// Surfaces whose triangles do not share points, and open surfaces that only a wrap can mend.
#include <fmt/format.h>

#include "geometry/mesh/length_unit.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/surface.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

// Each triangle with three points of its own.
Surface apart(const Surface& surface) {
  Surface result;
  for (const Triangle& t : surface.triangles) {
    const auto first = static_cast<NodeIndex>(result.nodes.size());
    for (const NodeIndex node : t) result.nodes.push_back(surface.nodes[static_cast<std::size_t>(node)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

void check_cube(const Surface& surface) {
  const SurfaceSummary sum = summarise(surface);
  CHECK(sum.nodes == 8);
  CHECK(sum.triangles == 12);
  CHECK(sum.closed());
  CHECK(sum.volume == Approx(1).epsilon(1e-14));
}

}  // namespace

TEST_CASE("points that coincide exactly are one: a surface whose triangles share none is closed") {
  const TemporaryFolder folder;
  Surface cube = apart(test::unit_cube());
  for (Vec3& x : cube.nodes)
    if (x[0] == 0) x[0] = -0.0;
  CHECK_FALSE(summarise(cube).closed());
  for (const auto& [name, content] : test::surface_files(cube)) {
    INFO(name);
    check_cube(read_surface(folder.write(name, content)));
  }
  cube.nodes[4][1] += 1e-12;  // near is not the same
  CHECK(read_surface(folder.write("near.obj", test::surface_files(cube).at("s.obj"))).nodes.size() == 9);
}

TEST_CASE("PLY: triangle strips are refused by name") {
  const TemporaryFolder folder;
  const auto file =
      folder.write("strips.ply",
                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                   "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                   "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  CHECK_THAT(error_of([&] { read_surface(file); }),
             Contains("strips.ply:9: triangle strips are not read, expected faces"));
}

TEST_CASE("an open surface that must be wrapped becomes a solid, not a thin shell around its skin") {
  // A ball without its top, and a second one that cuts through it and, by a spike from its top, through itself.
  const Surface ball = boundary_surface(phantom("ball", 3000));
  const Box box = bounding_box(ball);
  const double radius = 0.5 * box.size()[2];
  Surface open;
  open.nodes = ball.nodes;
  for (const Triangle& t : ball.triangles)
    if (ball.nodes[static_cast<std::size_t>(t[0])][2] < box.centre()[2] + 0.5 * radius)
      open.triangles.push_back(t);
  const auto shift = static_cast<NodeIndex>(open.nodes.size());
  for (const Vec3& x : ball.nodes) {
    const bool spike = x[2] > box.centre()[2] + 0.9 * radius;
    open.nodes.push_back(x + Vec3(radius, 0, spike ? -2.2 * radius : 0));
  }
  for (const auto& [a, b, c] : ball.triangles) open.triangles.push_back({a + shift, b + shift, c + shift});
  RepairReport report;
  const Surface solid = repair_surface(open, report);
  CHECK(report.wrapped);
  const double sphere = 4.0 / 3 * M_PI * radius * radius * radius;
  CHECK(enclosed_volume(solid) > 1.3 * sphere);  // the union, less the cap, has 1.53
  CHECK(enclosed_volume(solid) < 1.8 * sphere);
  // Without the spike the hole is filled and the balls are united.
  for (std::size_t i = 0; i < ball.nodes.size(); ++i)
    open.nodes[shift + i] = ball.nodes[i] + Vec3(radius, 0, 0);
  const Surface both = repair_surface(open, report);
  CHECK(report.united);
  CHECK_FALSE(report.wrapped);
  CHECK(enclosed_volume(both) == Approx(1.53 * sphere).epsilon(0.05));
}

TEST_CASE("an unlikely size is said, with the units that make it likely") {
  const auto of = [](double side, double taken = 1) {
    return unlikely_size({Vec3::Zero(), Vec3(side, side / 2, side / 3)}, taken);
  };
  CHECK(of(0.2).empty());
  CHECK(of(1).empty());
  CHECK(of(0).empty());
  CHECK(of(213) == "is 213 m long; if its lengths are in mm, it is 0.213 m long");
  CHECK(of(30) == "is 30 m long; if its lengths are in cm, it is 0.3 m long, in mm, it is 0.03 m long");
  CHECK(of(2e-4, 1e-3) == "is 0.0002 m long; if its lengths are in m, it is 0.2 m long");
  CHECK(of(1e9) == "is 1e+09 m long");
  CHECK(unit_of("mm") == 1e-3);
  CHECK_FALSE(unit_of("inch"));
}
