#include <signal.h>
#include <unistd.h>

#include "geometry/meshing/child_process.hpp"
#include "geometry/meshing/phantom.hpp"
#include "geometry/meshing/tetrahedralise.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

void append(Surface& to, const Surface& from, const Vec3& shift, double scale, bool inward = false) {
  const auto first = static_cast<NodeIndex>(to.nodes.size());
  for (const Vec3& node : from.nodes) to.nodes.push_back(scale * node + shift);
  for (const auto& [a, b, c] : from.triangles)
    to.triangles.push_back(inward ? Triangle{first + a, first + c, first + b}
                                  : Triangle{first + a, first + b, first + c});
}

}  // namespace

TEST_CASE("every surface format gives the same surface") {
  const TemporaryFolder folder;
  const Surface cube = test::unit_cube();
  for (const auto& [name, content] : test::surface_files(cube)) {
    INFO(name);
    const Surface surface = read_surface(folder.write(name, content));
    REQUIRE(surface.triangles.size() == 12);
    CHECK(surface.nodes.size() == 8);
    CHECK(enclosed_volume(surface) == Approx(1).epsilon(1e-14));
    for (std::size_t t = 0; t < 12; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        CHECK(surface.nodes[std::size_t(surface.triangles[t][k])] ==
              cube.nodes[std::size_t(cube.triangles[t][k])]);
  }
}

TEST_CASE("a surface file cut at any byte or damaged is refused in one line, or still a surface") {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  for (const auto& [name, content] : test::surface_files(test::unit_cube())) {
    const auto sound = [&folder, &name = name](const std::string& text) {
      const auto file = folder.write("bad_" + name, text);
      const std::string line = error_of([&] { read_surface(file); });
      return line.empty() || (line.starts_with(file.string()) && line.find('\n') == std::string::npos);
    };
    for (std::size_t n = 0; n < content.size(); ++n)
      if (!sound(content.substr(0, n))) FAIL_CHECK(name << " cut after " << n);
    for (int trial = 0; trial < 300; ++trial) {
      std::string damaged = content;
      damaged[random() % damaged.size()] =
          trial % 2 ? static_cast<char>(random()) : "0123456789-.e \n"[random() % 15];
      if (!sound(damaged)) FAIL_CHECK(name << " trial " << trial);
    }
  }
}

TEST_CASE("surface errors name file and line") {
  const TemporaryFolder folder;
  const auto refused = [&](const char* name, const std::string& text, const char* line) {
    const auto file = folder.write(name, text);
    CHECK_THAT(error_of([&] { read_surface(file); }), Contains(name, line));
  };
  refused("a.obj", "", "is empty");
  refused("a.obj", "v 0 0 0\n", "holds no triangles");
  refused("a.obj", "v 0 0 0\nv 1 x 0\n", "a.obj:2: 'x' is not a number");
  refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
          "a.obj:4: a face names vertex 4 (from 1), but there are 3");
  refused("a.obj", "v 0 0 0\nf 1 2 0\n", "a.obj:2: '0' is no vertex");
  refused("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj:1: 'nan' is not a number");
  refused("a.off", "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
          "vertex 0 (from 0) has a coordinate that is not finite");
  refused("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a face names vertex 3 (from 0)");
  refused("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1\n", "expected");
  refused("a.ply", "ply\nformat weird 1.0\nend_header\n", "a.ply:2: format 'weird'");
  refused("a.stl", "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\n", "ends where");
  refused("a.txt", "hello", "unknown kind of surface");
}

TEST_CASE("a closed cube becomes tetrahedra that fill it exactly") {
  for (const std::size_t elements : {0ul, 400ul, 3000ul}) {
    INFO(elements);
    TetrahedraliseReport report;
    TetMesh mesh = tetrahedralise(test::unit_cube(), {.elements = elements, .length = 0.1}, &report);
    CHECK(check_and_orient(mesh, "cube").warnings.empty());
    CHECK(mesh_quality(mesh).volume == Approx(1e-3).epsilon(1e-6));
    if (elements != 0) CHECK(std::abs(double(mesh.tets.size()) / double(elements) - 1) <= 0.05);
    CHECK(report.hausdorff < 1e-5);
    CHECK(report.repair.self_intersections == 0);
    CHECK(!report.repair.wrapped);
  }
}

TEST_CASE("holes, flipped triangles, doubled nodes and inward surfaces are repaired") {
  RepairReport report;
  Surface open = test::unit_cube();
  open.triangles.resize(10);
  CHECK(enclosed_volume(repair_surface(open, report)) == Approx(1).epsilon(1e-12));
  CHECK(report.holes == 1);

  Surface mixed = test::unit_cube();
  for (std::size_t t = 0; t < 12; t += 3) std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  CHECK(enclosed_volume(repair_surface(mixed, report)) == Approx(1).epsilon(1e-12));
  CHECK(report.reoriented);

  Surface soup;  // each triangle with nodes of its own
  const Surface cube = test::unit_cube();
  for (const Triangle& t : cube.triangles) {
    const auto n = static_cast<NodeIndex>(soup.nodes.size());
    for (const NodeIndex node : t) soup.nodes.push_back(cube.nodes[std::size_t(node)]);
    soup.triangles.push_back({n, n + 2, n + 1});
  }
  const Surface whole = repair_surface(soup, report);
  CHECK(whole.nodes.size() == 8);
  CHECK(enclosed_volume(whole) == Approx(1).epsilon(1e-12));
  CHECK(report.components == 1);
}

TEST_CASE("two intersecting boxes become one body") {
  Surface crossing = test::unit_cube();
  append(crossing, test::unit_cube(), {0.5, 0.4, 0.3}, 1);
  TetrahedraliseReport report;
  TetMesh mesh = tetrahedralise(crossing, {.elements = 1500}, &report);
  CHECK(report.repair.self_intersections > 0);
  CHECK(check_and_orient(mesh, "union").warnings.empty());
  CHECK(mesh_quality(mesh).volume ==
        Approx(2 - 0.5 * 0.6 * 0.7).epsilon(0.12));  // their union, wrapped with an offset
}

TEST_CASE("a cavity stays empty") {
  Surface hollow = test::unit_cube();
  append(hollow, test::unit_cube(), {0.25, 0.25, 0.25}, 0.5, true);
  TetMesh mesh = tetrahedralise(hollow, {.elements = 2500});
  CHECK(check_and_orient(mesh, "hollow").warnings.empty());
  CHECK(mesh_quality(mesh).volume == Approx(1 - 0.125).epsilon(1e-3));
}

TEST_CASE("a surface that encloses nothing is refused") {
  Surface flat;
  flat.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.triangles = {{0, 1, 2}};
  CHECK_THROWS_AS(tetrahedralise(flat, {.elements = 100}), InputError);
  Surface point;
  point.nodes = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  point.triangles = {{0, 1, 2}};
  CHECK_THROWS_AS(tetrahedralise(point, {}), InputError);
  CHECK_THROWS_WITH(tetrahedralise({}, {.name = "nothing.obj"}), Contains("nothing.obj: holds no triangles"));
  CHECK_THROWS_AS(tetrahedralise(test::unit_cube(), {.length = -1.0}), InputError);
}

TEST_CASE("the limit of time holds for repair and all tries together, and is said") {
  const auto line = error_of([] {
    tetrahedralise(test::unit_cube(), {.elements = 200'000, .name = "cube.obj", .time_limit = 0.05});
  });
  CHECK_THAT(line, Contains("cube.obj: no mesh was found in 0.05 s, the limit of time"));
  std::atomic<bool> stop = true;
  CHECK_THAT(error_of([&] { tetrahedralise(test::unit_cube(), {.stop = &stop}); }),
             Contains("interrupted while it was meshed"));
}

TEST_CASE("a body of no size that can be solved is refused, as a coordinate of 1e37 makes it") {
  for (const double far : {1e37, 1e7}) {
    Surface torn = test::unit_cube();
    torn.nodes.back() = Vec3::Constant(far);
    CHECK_THAT(error_of([&] { tetrahedralise(torn, {.elements = 400, .name = "torn.obj"}); }),
               Contains("torn.obj: is 1e+", "m long, expected 1e-06 to 1e+06 m"));
  }
}

TEST_CASE("what runs apart returns bytes, and its prints, crashes and loops stay there") {
  using End = ChildOutcome::End;
  const auto later = [](int ms) { return std::chrono::steady_clock::now() + std::chrono::milliseconds(ms); };
  const ChildOutcome good = run_apart({.deadline = later(60'000)}, [](int out) {
    std::puts("Assertion failed");
    std::fflush(stdout);
    return write_to(out, "abc", 3) ? 0 : 1;
  });
  CHECK(good.end == End::exited);
  CHECK(good.code == 0);
  CHECK(good.data == "abc");
  const ChildOutcome crash = run_apart({.deadline = later(60'000)}, [](int) {
    ::raise(SIGKILL);
    return 0;
  });
  CHECK(crash.end == End::signalled);
  CHECK(crash.code == SIGKILL);
  const ChildOutcome thrown = run_apart({.deadline = later(60'000)}, [](int) -> int { throw 1; });
  CHECK(thrown.code == child_threw);
  const auto loop = [](int) {
    for (;;) ::pause();
    return 0;
  };
  CHECK(run_apart({.deadline = later(50)}, loop).end == End::late);
  const std::atomic<bool> stop = true;
  CHECK(run_apart({.deadline = later(60'000), .stop = &stop}, loop).end == End::stopped);
}

TEST_CASE("Hausdorff distance of shifted and scaled bodies") {
  Surface shifted = test::unit_cube();
  for (Vec3& node : shifted.nodes) node += Vec3(0.25, 0, 0);
  CHECK(hausdorff_distance(test::unit_cube(), shifted) == Approx(0.25).epsilon(1e-12));
  Surface large;
  append(large, test::unit_cube(), {-0.5, -0.5, -0.5}, 2);
  CHECK(hausdorff_distance(test::unit_cube(), large) ==
        Approx(std::sqrt(0.75)).epsilon(1e-12));  // corner to corner
  CHECK(hausdorff_distance(large, test::unit_cube()) == Approx(std::sqrt(0.75)).epsilon(1e-12));
}

TEST_CASE("phantom surfaces are closed and enclose their bodies") {
  for (const std::string& name : phantom_names()) {
    INFO(name);
    CHECK(enclosed_volume(phantom_surface(name)) == Approx(mesh_quality(phantom(name)).volume).epsilon(1e-3));
  }
}

TEST_CASE("the real liver is meshed with the wanted numbers of elements", "[shared]") {
  if (shared_folder().empty()) return skip("no reference data beside the sources");
  const Surface liver = read_surface(shared_folder() + "/liver/liver-smooth.obj");
  REQUIRE(liver.triangles.size() == 4384);
  for (const std::size_t elements : {1777ul, 8000ul}) {
    TetrahedraliseReport report;
    TetMesh mesh = tetrahedralise(liver, {.elements = elements, .length = 0.22}, &report);
    CHECK(check_and_orient(mesh, "liver").warnings.empty());
    CHECK(std::abs(double(mesh.tets.size()) / double(elements) - 1) <= 0.05);
    CHECK(report.repair.self_intersections > 0);
    CHECK(longest_side(mesh) == Approx(0.22).epsilon(1e-12));
    CHECK(mesh_quality(mesh).min_dihedral_deg > 8);
    CHECK(report.hausdorff < 0.011);
  }
}
