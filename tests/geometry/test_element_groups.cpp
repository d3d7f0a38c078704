// Groups of tetrahedra in every format that has them.
#include <catch2/catch.hpp>

#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/mesh_formats.hpp"
#include "geometry/mesh/mesh_summary.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/labelled_meshes.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;
using Groups = std::map<std::string, std::vector<TetIndex>>;

namespace {

const Groups labels{
    {"tissue_-2", {1}}, {"tissue_4", {0}}, {"tumour", {1}}, {"tumour_0", {0}}, {"tumour_1", {1}}};

}  // namespace

TEST_CASE("element groups: physical volumes of Gmsh, references of Medit, labels in cell arrays of VTK") {
  const test::TemporaryFolder folder;
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
  const test::TemporaryFolder folder;
  const TetMesh mesh = read_mesh(folder.write("1.msh", test::labelled_gmsh1));
  CHECK(mesh.nodes[4] == Vec3(1, 1, 1));
  CHECK(mesh.groups.at("physical_2_5") == std::vector<NodeIndex>{0, 1, 2});
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string content = test::labelled_gmsh1;
    content.replace(content.find(from), from.size(), to);
    const auto file = folder.write("bad.msh", content);
    return test::error_of([&] { read_mesh(file); });
  };
  CHECK_THAT(refused("2 4 1 2 3 4", "2 5 1 2 3 4"),
             Catch::Contains("bad.msh:12: an element of 5 nodes, expected 4"));
  CHECK_THAT(refused("2 3 4 9", "2 3 4 5"), Catch::Contains("names node 5"));
  CHECK_THAT(refused("$ENDELM", "$ENDNOD"), Catch::Contains("where $ENDELM was expected"));
  CHECK_THAT(refused("$ELM", "$Elements"), Catch::Contains("where $NOD or $ELM was expected"));
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
  const test::TemporaryFolder folder;
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
  const test::TemporaryFolder folder;
  const MeshSummary sum = summarise(read_mesh(folder.write("22.msh", test::labelled_gmsh22)));
  REQUIRE(sum.regions.size() == 2);
  CHECK(sum.regions[0].name == "a tumour");
  CHECK(sum.regions[0].elements == 1);
  CHECK(sum.regions[0].volume == Approx(1.0 / 3));
  CHECK(sum.regions[1].volume == Approx(1.0 / 6));
}

TEST_CASE("labels that VTK itself wrote, ASCII and binary, old and new") {
  const test::TemporaryFolder folder;
  folder.write("labels.vtk", test::labelled_legacy);
  const auto script = folder.write("write.py", R"(import sys
try:
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader, vtkUnstructuredGridWriter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
except ImportError:
    sys.exit(77)
folder = sys.argv[1]
reader = vtkUnstructuredGridReader()
reader.SetFileName(folder + '/labels.vtk')
reader.ReadAllScalarsOn()
reader.ReadAllFieldsOn()
reader.Update()
grid = reader.GetOutput()
assert grid.GetCellData().GetArray('tissue') and grid.GetCellData().GetArray('tumour')
for version in (42, 51):
    for binary in (0, 1):
        w = vtkUnstructuredGridWriter()
        w.SetFileVersion(version)
        (w.SetFileTypeToBinary if binary else w.SetFileTypeToASCII)()
        w.SetFileName('%s/vtk_%d_%d.vtk' % (folder, version, binary))
        w.SetInputData(grid)
        assert w.Write()
for mode in ('Ascii', 'Binary', 'Appended'):
    w = vtkXMLUnstructuredGridWriter()
    getattr(w, 'SetDataModeTo' + mode)()
    w.SetFileName('%s/vtk_%s.vtu' % (folder, mode))
    w.SetInputData(grid)
    assert w.Write()
)");
  const int status = std::system(
      ("/usr/bin/python3 " + script.string() + " " + folder.path().string() + " 2>/dev/null").c_str());
  if (WIFEXITED(status) && (WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127))
    return test::skip("python3-vtk9 is not installed");
  REQUIRE(status == 0);
  for (const char* name : {"vtk_42_0.vtk", "vtk_42_1.vtk", "vtk_51_0.vtk", "vtk_51_1.vtk", "vtk_Ascii.vtu",
                           "vtk_Binary.vtu", "vtk_Appended.vtu"}) {
    INFO(name);
    CHECK(read_mesh(folder / name).element_groups == labels);
  }
}
