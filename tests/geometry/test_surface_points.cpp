// Surfaces whose triangles do not share points, triangle strips, and open surfaces that only a wrap can mend.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "geometry/mesh/length_unit.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/surface.hpp"
#include "geometry/meshing/surface_summary.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;

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

std::string vtp(const Surface& surface) {
  std::string points, corners, offsets;
  for (const Vec3& x : surface.nodes) points += fmt::format("{} {} {}\n", x[0], x[1], x[2]);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const NodeIndex node : surface.triangles[t]) corners += fmt::format("{} ", node);
    offsets += fmt::format("{} ", 3 * (t + 1));
  }
  const auto array = [](const char* name, const char* type, const std::string& text, int components) {
    return fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">{}</DataArray>", type,
        name, components, text);
  };
  return fmt::format(
      "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData><Piece "
      "NumberOfPoints=\"{}\" "
      "NumberOfPolys=\"{}\"><Points>{}</Points><Polys>{}{}</Polys></Piece></PolyData></VTKFile>\n",
      surface.nodes.size(), surface.triangles.size(), array("Points", "Float64", points, 3),
      array("connectivity", "Int64", corners, 1), array("offsets", "Int64", offsets, 1));
}

void check_cube(const Surface& surface) {
  const SurfaceSummary sum = summarise(surface);
  CHECK(sum.nodes == 8);
  CHECK(sum.triangles == 12);
  CHECK(sum.closed());
  CHECK(sum.volume == Approx(1).epsilon(1e-14));
}

const std::string strip_vertices = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
// The cube as three strips of one list: around its sides, its bottom, its top.
const std::vector<std::int32_t> strips{4, 0, 5, 1, 7, 3, 6, 2, 4, 0, -1, 0, 2, 1, 3, -1, 4, 5, 6, 7, -1};

std::string ply_header(const char* format) {
  return fmt::format(
      "ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n",
      format);
}

}  // namespace

TEST_CASE("points that coincide exactly are one: a surface whose triangles share none is closed") {
  const test::TemporaryFolder folder;
  Surface cube = apart(test::unit_cube());
  for (Vec3& x : cube.nodes)
    if (x[0] == 0) x[0] = -0.0;
  CHECK_FALSE(summarise(cube).closed());
  check_cube(read_surface(folder.write("cube.vtp", vtp(cube))));
  for (const auto& [name, content] : test::surface_files(cube)) {
    INFO(name);
    check_cube(read_surface(folder.write(name, content)));
  }
  cube.nodes[4][1] += 1e-12;  // near is not the same
  CHECK(read_surface(folder.write("near.vtp", vtp(cube))).nodes.size() == 9);
}

TEST_CASE("PLY: triangle strips, in ASCII and binary") {
  const test::TemporaryFolder folder;
  std::string text = ply_header("ascii") + strip_vertices + std::to_string(strips.size());
  for (const std::int32_t entry : strips) text += ' ' + std::to_string(entry);
  const Surface surface = read_surface(folder.write("strips.ply", text + "\n"));
  check_cube(surface);
  std::string binary = ply_header("binary_little_endian");
  const auto put = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int node = 0; node < 8; ++node)
    for (int k = 0; k < 3; ++k) put(static_cast<float>(node >> k & 1));
  put(static_cast<std::int32_t>(strips.size()));
  for (const std::int32_t entry : strips) put(entry);
  const Surface same = read_surface(folder.write("binary.ply", binary));
  CHECK(same.triangles == surface.triangles);
  CHECK(same.nodes == surface.nodes);
  const auto bad = folder.write("bad.ply", std::string(text).replace(text.rfind(" 7"), 2, " 9"));
  CHECK_THAT(test::error_of([&] { read_surface(bad); }), Catch::Contains("a face names vertex 9 (from 0)"));
  const auto negative = folder.write("negative.ply", std::string(text).replace(text.rfind(" 7"), 2, " -2"));
  CHECK_THAT(test::error_of([&] { read_surface(negative); }), Catch::Contains("-2 is no vertex"));
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
