// A moving body as .vtu files: what is written is read back; damaged files are refused.

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/vtu_series.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

TetMesh two_tets() {
  TetMesh mesh;
  mesh.nodes = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  mesh.tets = {{1, 2, 3, 4}, {2, 3, 4, 5}};
  return mesh;
}

fs::path write_frame(const TemporaryFolder& folder, bool surface, std::vector<float>& u) {
  const TetMesh mesh = two_tets();
  std::vector<NodeIndex> nodes = surface_nodes(mesh);
  if (!surface) {
    nodes.resize(mesh.nodes.size());
    std::iota(nodes.begin(), nodes.end(), 0);
  }
  u.clear();
  for (std::size_t i = 0; i < 3 * nodes.size(); ++i) u.push_back(0.25f * static_cast<float>(i) - 1);
  const VtuSeries series(mesh, nodes, surface);
  return folder.write("frame.vtu", series.frame(0.125, {1, 2, 3}, u));
}

}  // namespace

TEST_CASE("displacements and node numbers come back as they were written") {
  const TemporaryFolder folder;
  std::vector<float> u;
  for (const bool surface : {true, false}) {
    const MovedNodes read = read_moved_nodes(write_frame(folder, surface, u));
    REQUIRE(read.node.size() == (surface ? 5 : 6));
    CHECK(read.node.front() == (surface ? 1 : 0));
    for (std::size_t i = 0; i < read.node.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(read.moved[i][static_cast<Eigen::Index>(c)] == static_cast<double>(u[3 * i + c]));
  }
}

TEST_CASE("a file of the whole body is a mesh of the moved body") {
  const TemporaryFolder folder;
  std::vector<float> u;
  const TetMesh rest = two_tets(), moved = read_mesh(write_frame(folder, false, u));
  CHECK(moved.tets == rest.tets);
  for (std::size_t i = 0; i < rest.nodes.size(); ++i)
    for (int c = 0; c < 3; ++c)
      CHECK(moved.nodes[i][c] == Approx(rest.nodes[i][c] + u[3 * i + static_cast<std::size_t>(c)]));
}

TEST_CASE("the list of a series comes back; what is no series is refused") {
  const TemporaryFolder folder;
  const std::vector<SeriesFile> series{{.t = 0, .file = "shape/a.vtu"},
                                       {.t = 1.0 / 3, .file = "shape/b.vtu"}};
  write_pvd(folder / "s.pvd", series);
  const std::vector<SeriesFile> read = read_pvd(folder / "s.pvd");
  REQUIRE(read.size() == 2);
  CHECK(read[1].t == series[1].t);
  CHECK(read[1].file == "shape/b.vtu");
  CHECK_THROWS_AS(read_pvd(folder.write("bad.pvd", "<VTKFile type=\"PolyData\"/>")), InputError);
  CHECK_THROWS_AS(
      read_pvd(folder.write("bad.pvd", "<VTKFile type=\"Collection\"><DataSet timestep=\"x\" file=\"a\"/>")),
      InputError);
  CHECK_THROWS_AS(read_pvd(folder.write("bad.pvd", "<VTKFile type=\"Collection\"><DataSet timestep=\"0\"/>")),
                  InputError);
}

TEST_CASE("a file that is cut short or has no displacements is refused") {
  const TemporaryFolder folder;
  std::vector<float> u;
  const fs::path file = write_frame(folder, true, u);
  std::ifstream in(file, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  REQUIRE_NOTHROW(read_moved_nodes(file));
  for (const double part : {0.2, 0.5, 0.9})
    CHECK_THROWS_AS(
        read_moved_nodes(folder.write(
            "cut.vtu", whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))))),
        InputError);
  write_vtu(folder / "mesh.vtu", two_tets());
  CHECK_THROWS_AS(read_moved_nodes(folder / "mesh.vtu"), InputError);
}
