// VTK's surfaces, and how they are distinguished from meshes.

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/meshing/surface.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

TEST_CASE("a .vtk is a surface or a mesh by its DATASET, and each reader names the other kind") {
  const TemporaryFolder folder;
  const auto surface = folder.write("s.vtk", test::surface_files(test::unit_cube()).at("old.vtk"));
  const auto mesh = folder.write("m.vtk", test::sample_mesh_files().at("legacy3_ascii.vtk"));
  CHECK(is_surface_file(surface));
  CHECK_FALSE(is_surface_file(mesh));
  CHECK_FALSE(is_surface_file(folder / "absent.vtk"));
  CHECK_THAT(error_of([&] { read_mesh(surface); }), Contains("POLYDATA is a surface"));
  CHECK_THAT(error_of([&] { read_surface(mesh); }), Contains("UNSTRUCTURED_GRID is a mesh"));
}

TEST_CASE("triangle strips turn every second triangle; polygons are cut into fans") {
  const TemporaryFolder folder;
  const Surface strip = read_surface(folder.write(
      "s.vtk",
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 1 1 0\n"
      "LINES 1 3\n2 0 1\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"));
  CHECK(strip.triangles == std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}});
  const Surface square = read_surface(folder.write(
      "p.vtk",
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n"
      "POLYGONS 1 5\n4 0 1 2 3\n"));
  CHECK(square.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
  CHECK_THAT(
      error_of([&] {
        read_surface(folder.write("bad.vtk",
                                  "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n"
                                  "0 0 0\nPOLYGONS 1 4\n3 0 0 1\n"));
      }),
      Contains("a face names point 1, expected 0 to 0"));
}

TEST_CASE("surfaces that VTK itself wrote, as polygons and as strips, read back with the same volume",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const TemporaryFolder folder;
  const auto script = folder.write("write.py", R"(import sys
try:
    from vtkmodules.vtkFiltersCore import vtkStripper, vtkTriangleFilter
    from vtkmodules.vtkFiltersSources import vtkCubeSource
    from vtkmodules.vtkFiltersCore import vtkCleanPolyData
    from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
except ImportError:
    sys.exit(77)
folder = sys.argv[1]
cube = vtkCubeSource()
triangles = vtkTriangleFilter()
triangles.SetInputConnection(cube.GetOutputPort())
strips = vtkStripper()
strips.SetInputConnection(triangles.GetOutputPort())
for name, source in (('polygons', cube), ('strips', strips)):
    for version in (42, 51):
        for binary in (0, 1):
            w = vtkPolyDataWriter()
            w.SetFileVersion(version)
            (w.SetFileTypeToBinary if binary else w.SetFileTypeToASCII)()
            w.SetFileName('%s/%s_%d_%d.vtk' % (folder, name, version, binary))
            w.SetInputConnection(source.GetOutputPort())
            assert w.Write()
)");
  if (!python_ran(script.string() + " " + folder.path().string(), "python3-vtk9 is not installed")) return;
  for (const char* kind : {"polygons", "strips"})
    for (const char* name : {"_42_0.vtk", "_42_1.vtk", "_51_0.vtk", "_51_1.vtk"}) {
      INFO(kind << name);
      const auto file = folder / (std::string(kind) + name);
      CHECK(is_surface_file(file));
      const Surface surface = read_surface(file);
      CHECK(surface.triangles.size() == 12);
      CHECK(enclosed_volume(surface) == Approx(1).epsilon(1e-6));
    }
}
