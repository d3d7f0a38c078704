// Groups of tetrahedra in every format that has them.

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/mesh_formats.hpp"
#include "geometry/mesh/tet_mesh.hpp"
#include "tests/geometry/vtk_writer.hpp"
#include "tests/support/labelled_meshes.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

using Groups = std::map<std::string, std::vector<TetIndex>>;

namespace {

const Groups labels{
    {"tissue_-2", {1}}, {"tissue_4", {0}}, {"tumour", {1}}, {"tumour_0", {0}}, {"tumour_1", {1}}};

}  // namespace

TEST_CASE("element groups: physical volumes of Gmsh, references of Medit, labels in cell arrays of VTK") {
  const TemporaryFolder folder;
  const auto groups = [&](const char* name, const char* content) {
    const TetMesh mesh = read_mesh(folder.write(name, content));
    CHECK(mesh.nodes.size() == 5);
    CHECK(mesh.tets == std::vector<Tet>{{0, 1, 2, 3}, {1, 2, 3, 4}});
    return mesh.element_groups;
  };
  CHECK(groups("1.msh", test::labelled_gmsh1) == Groups{{"physical_3_7", {0}}, {"physical_3_8", {1}}});
  CHECK(groups("22.msh", test::labelled_gmsh22) == Groups{{"a tumour", {1}}, {"liver", {0}}});
  CHECK(groups("41.msh", test::labelled_gmsh41) == Groups{{"a tumour", {1}}, {"all", {0, 1}}});
  CHECK(groups("m.mesh", test::labelled_medit) == Groups{{"ref_tetrahedra_3", {1}}});
  CHECK(groups("l.vtk", test::labelled_legacy) == labels);
  CHECK(groups("x.vtu", test::labelled_vtu) == labels);
}

TEST_CASE("Gmsh 1: nodes, tetrahedra and physical regions; damage is refused by line") {
  const TemporaryFolder folder;
  const TetMesh mesh = read_mesh(folder.write("1.msh", test::labelled_gmsh1));
  CHECK(mesh.nodes[4] == Vec3(1, 1, 1));
  CHECK(mesh.groups.at("physical_2_5") == std::vector<NodeIndex>{0, 1, 2});
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string content = test::labelled_gmsh1;
    content.replace(content.find(from), from.size(), to);
    const auto file = folder.write("bad.msh", content);
    return error_of([&] { read_mesh(file); });
  };
  CHECK_THAT(refused("2 4 1 2 3 4", "2 5 1 2 3 4"),
             Contains("bad.msh:12: an element of 5 nodes, expected 4"));
  CHECK_THAT(refused("2 3 4 9", "2 3 4 5"), Contains("names node 5"));
  CHECK_THAT(refused("$ENDELM", "$ENDNOD"), Contains("where $ENDELM was expected"));
  CHECK_THAT(refused("$ELM", "$Elements"), Contains("where $NOD or $ELM was expected"));
}

TEST_CASE(
    "a cell array that is no label names no groups: fractions, more than 256 values, several components") {
  TetMesh mesh = test::sample_mesh();
  std::vector<CellLabel> fraction{{0, 1}, {1, 1.5}}, many, infinite{{0, 1}, {1, HUGE_VAL}};
  for (int i = 0; i < 300; ++i) many.push_back({0, static_cast<double>(i)});
  add_label_groups(mesh, "fraction", fraction);
  add_label_groups(mesh, "many", many);
  add_label_groups(mesh, "infinite", infinite);
  CHECK(mesh.element_groups.empty());
}

TEST_CASE("element groups are written as physical volumes and read back") {
  const TemporaryFolder folder;
  TetMesh mesh = read_mesh(folder.write("22.msh", test::labelled_gmsh22));
  mesh.groups["held"] = {0, 2};
  mesh.groups.erase("physical_2_5");
  mesh.element_groups.erase("liver");
  mesh.groups.erase("liver");
  write_msh(folder / "out.msh", mesh);
  const TetMesh back = read_mesh(folder / "out.msh");
  CHECK(back.element_groups == Groups{{"a tumour", {1}}});
  CHECK(back.groups ==
        std::map<std::string, std::vector<NodeIndex>>{{"a tumour", {1, 2, 3, 4}}, {"held", {0, 2}}});
  CHECK(back.tets == mesh.tets);
}

TEST_CASE("the summary of a mesh gives elements and volume of each region") {
  const TemporaryFolder folder;
  const MeshSummary sum = summarise(read_mesh(folder.write("22.msh", test::labelled_gmsh22)));
  REQUIRE(sum.regions.size() == 2);
  CHECK(sum.regions[0].name == "a tumour");
  CHECK(sum.regions[0].elements == 1);
  CHECK(sum.regions[0].volume == Approx(1.0 / 3));
  CHECK(sum.regions[1].volume == Approx(1.0 / 6));
}

TEST_CASE("labels that VTK itself wrote, ASCII and binary, old and new",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const TemporaryFolder folder;
  for (const fs::path& file :
       written_by_vtk(folder, labelled_legacy,
                      "grid.GetCellData().GetArray('tissue') and grid.GetCellData().GetArray('tumour')")) {
    INFO(file);
    CHECK(read_mesh(file).element_groups == labels);
  }
}

TEST_CASE(
    "a partitioned Gmsh 4.1 mesh keeps its groups: partitions share those of their parent, or name their "
    "own") {
  const TemporaryFolder folder;
  for (const bool own : {false, true}) {
    const std::string physical = own ? "1 5 " : "0 ";
    const std::string text =
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 5 \"liver\"\n$EndPhysicalNames\n"
        "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 5 0\n$EndEntities\n"
        "$PartitionedEntities\n2\n1\n7 2\n0 0 0 2\n"
        "2 3 1 1 1 0 0 0 1 1 1 " +
        physical + "0\n3 3 1 1 2 0 0 0 1 1 1 " + physical +
        "2 8 9\n$EndPartitionedEntities\n"
        "$Nodes\n1 5 1 5\n3 2 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n"
        "$Elements\n2 2 1 2\n3 2 4 1\n1 1 2 3 4\n3 3 4 1\n2 2 3 4 5\n$EndElements\n"
        "$GhostElements\n1\n1 2 1 1\n$EndGhostElements\n";
    const TetMesh mesh = read_mesh(folder.write("p.msh", text));
    CHECK(mesh.tets.size() == 2);
    CHECK(mesh.element_groups == Groups{{"liver", {0, 1}}});
  }
}

TEST_CASE("second-order tetrahedra give their corners in Gmsh and VTK, and bent edges are said") {
  const TemporaryFolder folder;
  const std::string points =
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.5 0 0\n0.5 0.5 0\n0 0.5 0\n0 0 0.5\n0.5 0 0.5\n0 0.5 0.5\n";
  std::string numbered;
  std::size_t at = 0;
  for (int i = 1; i <= 10; ++i) {
    const std::size_t end = points.find('\n', at);
    numbered += std::to_string(i) + " " + points.substr(at, end - at) + "\n";
    at = end + 1;
  }
  const auto gmsh = [&](const std::string& nodes) {
    return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n" + nodes +
           "$EndNodes\n$Elements\n1\n1 11 2 1 1 1 2 3 4 5 6 7 8 10 9\n$EndElements\n";
  };
  const std::string vtk =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n" + points +
      "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n";
  for (const auto& [name, text] :
       std::map<std::string, std::string>{{"a.msh", gmsh(numbered)}, {"b.vtk", vtk}}) {
    INFO(name);
    TetMesh mesh = read_mesh(folder.write(name, text));
    CHECK(mesh.tets == std::vector<Tet>{{0, 1, 2, 3}});
    CHECK(mesh.second_order.middle_nodes == std::vector<NodeIndex>{4, 5, 6, 7, 8, 9});
    CHECK(mesh.second_order.bent < 1e-12);
    CHECK(check_and_orient(mesh, name).warnings.empty());
  }
  numbered.replace(numbered.find("5 0.5 0 0"), 9, "5 0.5 -0.1 0");
  TetMesh bent = read_mesh(folder.write("bent.msh", gmsh(numbered)));
  CHECK(bent.second_order.bent == Approx(0.1));
  const auto said = check_and_orient(bent, "bent.msh").warnings;
  REQUIRE(said.size() == 1);
  CHECK_THAT(said[0], Contains("are straightened", "10.0 %"));
}

TEST_CASE("other volume elements are refused by name, with what to do") {
  const TemporaryFolder folder;
  const auto problem = [&](const std::string& type, int nodes) {
    std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n";
    for (int i = 1; i <= 8; ++i)
      text += std::to_string(i) + " " + std::to_string(i % 2) + " " + std::to_string(i / 2 % 2) + " " +
              std::to_string(i / 4) + "\n";
    text += "$EndNodes\n$Elements\n1\n1 " + type + " 2 1 1";
    for (int i = 1; i <= nodes; ++i) text += " " + std::to_string(i);
    const auto file = folder.write("h.msh", text + "\n$EndElements\n");
    return error_of([&] { read_mesh(file); });
  };
  CHECK_THAT(problem("5", 8), Contains("hexahedra (element type 5) are not read", "forefeel mesh"));
  CHECK_THAT(problem("6", 6), Contains("prisms (element type 6)"));
  CHECK_THAT(problem("7", 5), Contains("pyramids (element type 7)"));
}
