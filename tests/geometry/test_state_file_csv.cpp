#include "geometry/mesh/mesh_file.hpp"
#include "geometry/states/state_file.hpp"
#include "tests/support/test.hpp"

namespace {

std::vector<State> some_states() {
  std::vector<State> all(3);
  for (int i = 0; i < 3; ++i) {
    all[std::size_t(i)].at = {0.1 * i, 1.0 / 3, -2e-3};
    all[std::size_t(i)].force = {-0.1 * i, 1e-17, 3};
  }
  all[1].stiffness = Mat3::Identity() * 12.5;
  all[1].stiffness(0, 2) = -1.0 / 7;
  all[1].energy = 0.25;
  all[2].spacing = 0.006;
  return all;
}

}  // namespace

TEST_CASE("states survive the way through CSV bit for bit") {
  const TemporaryFolder folder;
  std::vector<State> all = some_states();
  write_states_csv(folder / "s.csv", all);
  const std::vector<State> again = read_states_csv(folder / "s.csv");
  REQUIRE(again.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(again[i].at == all[i].at);
    CHECK(again[i].force == all[i].force);
    CHECK(again[i].has_stiffness() == (i == 1));
    CHECK(again[i].solve.status == SolveStatus::measured);
  }
  CHECK(again[1].stiffness == all[1].stiffness);
  CHECK(again[1].energy == 0.25);
  CHECK(again[2].spacing == 0.006);
  all[0].solve.status = SolveStatus::diverged;
  write_states_csv(folder / "s.csv", all);
  CHECK(read_states_csv(folder / "s.csv").size() == 2);  // failed states have no force to give
  CHECK(load_states(folder / "s.csv").header.spacing == 0.006);
}

TEST_CASE("CSV columns by name, in any order, with comments and line ends of either kind") {
  const TemporaryFolder folder;
  const auto file = folder.write("s.csv",
                                 "\xef\xbb\xbf# measured\r\nfz, fy "
                                 ",fx,z,y,x,note,converged\r\n\r\n1,2,3,4,5,6,hello,1\r\n1,2,3,4,5,7,,0\r\n");
  const std::vector<State> states = read_states_csv(file);
  REQUIRE(states.size() == 2);
  CHECK(states[0].at == Vec3(6, 5, 4));
  CHECK(states[0].force == Vec3(3, 2, 1));
  CHECK(states[0].solve.status == SolveStatus::converged);
  CHECK(!states[1].usable());
  CHECK(read_points_csv(folder.write("p.csv", "x,y,z\n1,2,3\n-1e-3,+2,.5\n")) ==
        std::vector<Vec3>{{1, 2, 3}, {-1e-3, 2, 0.5}});
  CHECK(read_points_csv(folder.write("p.csv", "1,2,3\n4,5,6\n")).size() == 2);
}

TEST_CASE("CSV errors name file and line") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const char* line) {
    const auto file = folder.write("bad.csv", text);
    CHECK_THAT(error_of([&] { read_states_csv(file); }), Contains("bad.csv", line));
  };
  const std::string head = "x,y,z,fx,fy,fz\n";
  refused("", "is empty");
  refused(head, "holds no states");
  refused("x,y,z,fx,fy\n1,2,3,4,5\n", "bad.csv:1: no column fz");
  refused("1,2,3,4,5,6\n", "bad.csv:1: no column x");
  refused("0.5,0,0,4,5,6\n", "this one begins with '0.5'");
  refused(head + "1,2,3,4,5,6\n\n1,2,3,4,5\n", "bad.csv:4: 5 columns, expected 6");
  refused(head + "1,2,3,4,5,6,7\n", "bad.csv:2: 7 columns, expected 6");
  refused(head + "1,2,nan,4,5,6\n", "bad.csv:2: column z: 'nan' is not finite");
  refused(head + "1,2,3,inf,5,6\n", "column fx: 'inf' is not finite");
  refused(head + "1,2,3,4,1e160,6\n", "bad.csv:2: a position, force or stiffness is above 1e+100");
  refused(head + "1,2,3,4,,6\n", "column fy: '' is not a number");
  refused(head + "1,2,3,4,5.0.0,6\n", "column fy: '5.0.0' is not a number");
  refused("x;y;z;fx;fy;fz\n1;2;3;4;5;6\n", "not separated by commas");
  refused("x,y,z,fx,fy,fz,x\n1,2,3,4,5,6,7\n", "column x is there twice");
  refused("x,y,z,fx,fy,fz,k11\n1,2,3,4,5,6,7\n", "1 of the nine columns");
  refused("x,y,z,fx,fy,fz,k11,k12,k13,k21,k22,k23,k31,k32,k33\n1,2,3,4,5,6,1,,,,,,,,\n", "only partly known");
  refused("x,y,z,fx,fy,fz,h\n1,2,3,4,5,6,0\n", "is not a spacing");
  refused("x,y,z,fx,fy,fz,status\n1,2,3,4,5,6,fine\n", "status 'fine' is unknown");
  CHECK_THAT(error_of([&] { read_points_csv(folder / "absent.csv"); }), Contains("cannot be read"));
  CHECK_THAT(error_of([&] { read_points_csv(folder.write("p.csv", "x,y,z\n1,2\n")); }),
             Contains("p.csv:2: 2 columns, expected 3"));
  CHECK_THAT(error_of([&] { load_states(folder.write("b.csv", std::string("\0\1\2", 3))); }),
             Contains("neither a state file nor a CSV"));
  CHECK_THAT(error_of([&] { write_states_csv("/dev/full", some_states()); }), Contains("No space left"));
}

TEST_CASE("a CSV cut at any byte is refused or read") {
  const TemporaryFolder folder;
  write_states_csv(folder / "s.csv", some_states());
  std::ifstream in(folder / "s.csv");
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  for (std::size_t n = 0; n < good.size(); ++n) {
    const auto file = folder.write("cut.csv", good.substr(0, n));
    const std::string line = error_of([&] { read_states_csv(file); });
    CHECK_THAT(line, !Contains("\n"));
  }
}

TEST_CASE("the exported VTU is what VTK's own reader makes of it",
          SLOW("compares with VTK, which only run.sh all installs")) {
  const TemporaryFolder folder;
  std::vector<State> all = some_states();
  write_states_vtu(folder / "s.vtu", all);
  // Our own reader finds points and no tetrahedra.
  CHECK(read_mesh(folder / "s.vtu").nodes[2] == all[2].at);
  const auto script = folder.write("read.py", R"(import sys
try:
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as Reader
except ImportError:
    sys.exit(77)
reader = Reader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
data = grid.GetPointData()
assert grid.GetNumberOfPoints() == 3 and grid.GetNumberOfCells() == 3
assert grid.GetPoint(1) == (0.1, 1.0 / 3, -2e-3), grid.GetPoint(1)
assert data.GetArray("force").GetTuple3(2)[2] == 3
assert data.GetArray("stiffness").GetComponent(1, 2) == -1.0 / 7
assert data.GetArray("energy").GetValue(1) == 0.25
)");
  python_ran(script.string() + " " + (folder / "s.vtu").string(), "python3-vtk9 is not installed");
}
