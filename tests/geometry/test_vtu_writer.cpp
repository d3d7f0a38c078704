// The writer of .vtu files in its four forms: our reader and VTK's find the same values in them.

#include "geometry/mesh/mesh_file.hpp"
#include "geometry/mesh/vtu_writer.hpp"
#include "tests/support/test.hpp"

namespace {

const std::vector<Vec3> corners{{0, 0, 0}, {1.0 / 3, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1e-30}};
const std::vector<Tet> tets{{0, 1, 2, 3}, {1, 2, 3, 4}};

void write(const fs::path& file, VtuData data) {
  VtuWriter out(file, data);
  out.begin(corners.size(), tets.size());
  out.section("PointData", "Scalars=\"a &amp; b\"");
  out.array<double>("a & b", corners.size(), 1, [](std::size_t i, int) { return 0.1 * double(i); });
  out.array<float>("pair", corners.size(), 2, [](std::size_t i, int k) { return i + 0.5 * k; });
  out.array<std::int32_t>("whole", corners.size(), 1, [](std::size_t i, int) { return -int(i); });
  out.array<double>("unknown", corners.size(), 1,
                    [](std::size_t, int) { return std::numeric_limits<double>::quiet_NaN(); });
  out.section("CellData");
  out.array<std::uint8_t>("tissue", tets.size(), 1, [](std::size_t i, int) { return 3 + i; });
  out.points(corners);
  out.cells(tets, vtk_cell::tetra);
  out.finish();
}

}  // namespace

TEST_CASE("a grid is the same as text, base64, raw and compressed data",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const TemporaryFolder folder;
  const std::pair<const char*, VtuData> kinds[] = {{"text.vtu", VtuData::text},
                                                   {"base64.vtu", VtuData::base64},
                                                   {"raw.vtu", VtuData::raw},
                                                   {"packed.vtu", VtuData::packed}};
  std::string files;
  for (const auto& [name, data] : kinds) {
    CAPTURE(name);
    write(folder / name, data);
    files += " " + (folder / name).string();
    const TetMesh mesh = read_mesh(folder / name);
    CHECK(mesh.nodes == corners);
    CHECK(mesh.tets == tets);
    CHECK(mesh.element_groups.at("tissue_4") == std::vector<TetIndex>{1});
  }
  const auto script = folder.write("read.py", R"(import sys
try:
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as Reader
except ImportError:
    sys.exit(77)
for file in sys.argv[1:]:
    reader = Reader()
    reader.SetFileName(file)
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData()
    assert grid.GetNumberOfPoints() == 5 and grid.GetNumberOfCells() == 2, file
    assert grid.GetPoint(1) == (1.0 / 3, 0, 0), grid.GetPoint(1)
    assert data.GetArray('a & b').GetValue(3) == 0.1 * 3
    assert data.GetArray('pair').GetTuple2(2) == (2, 2.5)
    assert data.GetArray('whole').GetValue(4) == -4
    assert grid.GetCellData().GetArray('tissue').GetValue(1) == 4
    assert grid.GetCell(1).GetPointId(3) == 4
    if not file.endswith('text.vtu'):
        assert data.GetArray('unknown').GetValue(0) != data.GetArray('unknown').GetValue(0)
)");
  python_ran(script.string() + files, "python3-vtk9 is not installed");
}
