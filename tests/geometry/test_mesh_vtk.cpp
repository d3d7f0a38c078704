#include <catch2/catch.hpp>

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>

#include "geometry/mesh/mesh_file.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/slow.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;

TEST_CASE("files that VTK itself wrote read back as the same mesh",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const test::TemporaryFolder folder;
  folder.write("sample.vtk", test::sample_mesh_files().at("legacy3_ascii.vtk"));
  const auto script = folder.write("write.py", R"(import sys
try:
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader, vtkUnstructuredGridWriter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
except ImportError:
    sys.exit(77)
folder = sys.argv[1]
reader = vtkUnstructuredGridReader()
reader.SetFileName(folder + '/sample.vtk')
reader.Update()
grid = reader.GetOutput()
assert grid.GetNumberOfCells() == 3 and grid.GetPoint(5) == (1e-3, -1.5, 0.25)
for version in (42, 51):
    for binary in (0, 1):
        w = vtkUnstructuredGridWriter()
        w.SetFileVersion(version)
        (w.SetFileTypeToBinary if binary else w.SetFileTypeToASCII)()
        w.SetFileName('%s/vtk_%d_%d.vtk' % (folder, version, binary))
        w.SetInputData(grid)
        assert w.Write()
for mode in ('Ascii', 'Binary', 'Appended'):
    for compressor in ('None', 'ZLib'):
        for encode in (0, 1):
            for header in (32, 64):
                w = vtkXMLUnstructuredGridWriter()
                getattr(w, 'SetDataModeTo' + mode)()
                getattr(w, 'SetCompressorTypeTo' + compressor)()
                w.SetEncodeAppendedData(encode)
                (w.SetHeaderTypeToUInt32 if header == 32 else w.SetHeaderTypeToUInt64)()
                w.SetFileName('%s/vtk_%s_%s_%d_%d.vtu' % (folder, mode, compressor, encode, header))
                w.SetInputData(grid)
                assert w.Write()
)");
  const int status = std::system(
      ("/usr/bin/python3 " + script.string() + " " + folder.path().string() + " 2>/dev/null").c_str());
  if (WIFEXITED(status) && (WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127))
    return test::skip("python3-vtk9 is not installed");
  REQUIRE(status == 0);
  const TetMesh expected = test::sample_mesh();
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("vtk_")) continue;
    INFO(name);
    const TetMesh mesh = read_mesh(entry.path());
    REQUIRE(mesh.nodes.size() == expected.nodes.size());
    const double tolerance =
        name.find("_Ascii") != std::string::npos || name.ends_with("_0.vtk") ? 1e-9 : 0;  // printed digits
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
      CHECK((mesh.nodes[i] - expected.nodes[i]).norm() <= tolerance);
    CHECK(mesh.tets == expected.tets);
    ++files;
  }
  CHECK(files == 28);
}
