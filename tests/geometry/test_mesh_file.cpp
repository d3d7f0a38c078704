#include "geometry/mesh/mesh_file.hpp"

#include "geometry/common/scanner.hpp"
#include "geometry/meshing/phantom.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

namespace {

std::string refusal_of(const fs::path& file) {
  return error_of([&] {
    TetMesh mesh = read_mesh(file);
    check_and_orient(mesh, file.string());
  });
}

// Only a valid mesh or an error in one line passes.
bool sound(const fs::path& file) {
  try {
    TetMesh mesh = read_mesh(file);
    check_and_orient(mesh, file.string());
    return mesh_quality(mesh).volume > 0;
  } catch (const InputError& error) {
    const std::string line = error.what();
    return line.find(file.string()) == 0 && line.find('\n') == std::string::npos;
  }
}

}  // namespace

TEST_CASE("every format gives the same mesh") {
  const TemporaryFolder folder;
  const TetMesh expected = test::sample_mesh();
  for (const auto& [name, content] : test::sample_mesh_files()) {
    INFO(name);
    const TetMesh mesh = read_mesh(folder.write(name, content));
    REQUIRE(mesh.nodes.size() == expected.nodes.size());
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) CHECK(mesh.nodes[i] == expected.nodes[i]);
    CHECK(mesh.tets == expected.tets);
    if (name.ends_with(".msh")) CHECK(mesh.groups.at("held") == expected.groups.at("held"));
    if (name.ends_with(".mesh")) CHECK(mesh.groups.at("ref_vertices_7") == expected.groups.at("held"));
  }
}

TEST_CASE("an empty piece of .vtu, as a parallel program writes it, is passed over") {
  const TemporaryFolder folder;
  const TetMesh mesh = test::sample_mesh();
  write_mesh(folder / "a.vtu", mesh);
  std::string text = read_file(folder / "a.vtu");
  text.insert(text.find("<Piece"),
              "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"><Points/><Cells/></Piece>");
  CHECK(read_mesh(folder.write("b.vtu", text)).tets == mesh.tets);
}

TEST_CASE("a mesh written as .vtu is read back bit for bit, with its groups of nodes and of elements") {
  const TemporaryFolder folder;
  TetMesh mesh = phantom("ball", 300);
  mesh.groups["a name with spaces & <signs> \"too\""] = {1, 5, 9};
  mesh.element_groups = {{"core", {3, 4, 5}}, {"shell", {0, 1, 2}}};
  write_mesh(folder / "ball.vtu", mesh);
  const TetMesh back = read_mesh(folder / "ball.vtu");
  CHECK(back.nodes == mesh.nodes);
  CHECK(back.tets == mesh.tets);
  CHECK(back.groups == mesh.groups);
  CHECK(back.element_groups.at("core") == mesh.element_groups.at("core"));
  CHECK(back.element_groups.at("shell") == mesh.element_groups.at("shell"));
}

TEST_CASE("a written mesh is read back bit for bit") {
  const TemporaryFolder folder;
  TetMesh mesh = phantom("ball", 300);
  mesh.groups["a name with spaces"] = {1, 5, 9};
  write_msh(folder / "ball.msh", mesh);
  const TetMesh again = read_mesh(folder / "ball.msh");
  CHECK(again.nodes == mesh.nodes);
  CHECK(again.tets == mesh.tets);
  for (const auto& [name, nodes] : mesh.groups) CHECK(again.groups.at(name) == nodes);
  CHECK(folder.entries() == 1);  // no temporary file is left
}

TEST_CASE("a mesh file cut at any byte is refused in one line, or still a valid mesh") {
  const TemporaryFolder folder;
  for (const auto& [name, content] : test::sample_mesh_files())
    for (std::size_t length = 0; length < content.size(); ++length) {
      const auto file = folder.write("cut_" + name, content.substr(0, length));
      if (!sound(file)) FAIL_CHECK(name << " cut after " << length << " bytes");
    }
}

TEST_CASE("a mesh file with damaged bytes is refused in one line, or still a valid mesh") {
  const TemporaryFolder folder;
  std::mt19937 random(1);
  for (const auto& [name, content] : test::sample_mesh_files())
    for (int trial = 0; trial < 400; ++trial) {
      std::string damaged = content;
      for (int k = 0; k < 1 + trial % 3; ++k) {
        const std::size_t at = random() % damaged.size();
        damaged[at] = trial % 2 ? static_cast<char>(random()) : "0123456789-.e \n"[random() % 15];
      }
      const auto file = folder.write("damaged_" + name, damaged);
      if (!sound(file)) FAIL_CHECK(name << " trial " << trial);
    }
}

TEST_CASE("mesh errors name file and line") {
  const TemporaryFolder folder;
  const std::string good = test::sample_mesh_files().at("gmsh22_ascii.msh");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return refusal_of(folder.write("bad.msh", text.replace(at, from.size(), to)));
  };
  CHECK_THAT(refusal_of(folder / "absent.msh"), Contains("absent.msh: cannot be read"));
  CHECK_THAT(refusal_of(folder.write("empty.msh", "")), Contains("empty.msh: is empty"));
  CHECK_THAT(refusal_of(folder.path()), Contains("unknown kind of mesh"));
  CHECK_THAT(refusal_of(folder.write("what.stl", "solid")), Contains("expected .msh, .vtk, .vtu or .mesh"));
  CHECK_THAT(refusal_of(folder.write("hello.msh", "hello")), Contains("hello.msh:1: is not a Gmsh file"));
  CHECK_THAT(changed("1.25", "one"), Contains("bad.msh:12: 'one' is not a number"));
  CHECK_THAT(changed("1.25", "nan"), Contains("not finite"));
  CHECK_THAT(changed(" 13 ", " 14 "), Contains("names node 14, which is not in $Nodes"));
  CHECK_THAT(changed("2.2 0 8", "4.0 0 8"), Contains("bad.msh:2: Gmsh format 4.0 is not read"));
  CHECK_THAT(changed(" 4 2 1 1", " 5 2 1 1"), Contains("hexahedra (element type 5) are not read"));
  CHECK_THAT(changed("$Nodes\n6", "$Nodes\n999999999"), Contains("cut short"));
  CHECK_THAT(changed("$Nodes\n6", "$Nodes\n-6"), Contains("negative"));
  const std::string no_tets =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 2 0 1 "
      "1\n$EndElements\n";
  CHECK_THAT(refusal_of(folder.write("points.msh", no_tets)), Contains("holds no tetrahedra"));
}

TEST_CASE("a mesh that cannot be written is an error and leaves nothing") {
  const TemporaryFolder folder;
  const TetMesh mesh = test::sample_mesh();
  CHECK_THROWS_AS(write_msh(folder / "no/such/folder.msh", mesh), InputError);
  CHECK_THROWS_AS(write_msh(folder.path(), mesh), InputError);
  CHECK_THROWS_WITH(write_msh("/dev/full", mesh), Contains("cannot be written: No space left"));
  CHECK(folder.entries() == 0);
}

TEST_CASE("real Gmsh 2.2 files", "[shared]") {
  if (shared_folder().empty()) return skip("no reference data beside the sources");
  const TetMesh liver = read_mesh(shared_folder() + "/liver/liver_1777.msh");
  CHECK(liver.nodes.size() == 501);
  CHECK(liver.tets.size() == 1725);
  CHECK(longest_side(liver) == Approx(0.22).epsilon(0.02));
  const TetMesh beam = read_mesh(shared_folder() + "/beam/beam.msh");
  CHECK(mesh_quality(beam).volume == Approx(0.1 * 0.02 * 0.02).epsilon(1e-12));
}
