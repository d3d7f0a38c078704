#include "geometry/mesh/mesh_file.hpp"
#include "tests/geometry/vtk_writer.hpp"
#include "tests/support/mesh_samples.hpp"
#include "tests/support/test.hpp"

TEST_CASE("files that VTK itself wrote read back as the same mesh",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const TemporaryFolder folder;
  const auto files =
      written_by_vtk(folder, sample_mesh_files().at("legacy3_ascii.vtk"),
                     "grid.GetNumberOfCells() == 3 and grid.GetPoint(5) == (1e-3, -1.5, 0.25)");
  const TetMesh expected = sample_mesh();
  for (const fs::path& file : files) {
    const std::string name = file.filename().string();
    INFO(name);
    const TetMesh mesh = read_mesh(file);
    REQUIRE(mesh.nodes.size() == expected.nodes.size());
    const double tolerance =
        name.find("_Ascii") != std::string::npos || name.ends_with("_0.vtk") ? 1e-9 : 0;  // printed digits
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
      CHECK((mesh.nodes[i] - expected.nodes[i]).norm() <= tolerance);
    CHECK(mesh.tets == expected.tets);
  }
}
