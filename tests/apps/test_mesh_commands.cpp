// forefeel mesh, import, export and info, run as a person would.

#include <fmt/format.h>

#include "tests/support/executable.hpp"

namespace {

const char* const cube_off =
    "OFF\n8 12 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 "
    "6\n3 0 1 4\n3 1 5 4\n"
    "3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n";

}  // namespace

TEST_CASE("mesh fills a surface, rescales a mesh, and makes phantoms", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  const auto made = shop.json("mesh cube.off -o cube.msh --elements 600 --length 0.1");
  CHECK(made["elements"] == Approx(600).epsilon(0.05));
  CHECK(made["volume"] == Approx(1e-3).epsilon(1e-6));
  CHECK(made["hausdorff"].get<double>() < 1e-5);
  CHECK(made["min_dihedral_deg"].get<double>() > 10);
  CHECK(made["repaired"]["self_intersections"] == 0);
  const auto info = shop.json("info cube.msh");
  CHECK(info["kind"] == "mesh");
  CHECK(info["elements"] == made["elements"]);
  CHECK(info["components"] == 1);
  const auto longer = shop.json("mesh cube.msh -o longer.msh --length 0.2");
  CHECK(longer["volume"] == Approx(8e-3).epsilon(1e-6));
  CHECK(longer["elements"] == made["elements"]);
  const auto finer = shop.json("mesh cube.msh -o finer.msh --elements 1500");
  CHECK(finer["elements"] == Approx(1500).epsilon(0.05));
  const auto liver = shop.json("mesh --phantom liver -o liver.msh");
  CHECK(liver["elements"] == Approx(1777).epsilon(0.05));
  CHECK(liver["groups"].contains("clamp"));
  CHECK(shop.json("info liver.msh")["groups"]["contact"] == liver["groups"]["contact"]);
  CHECK(shop.json("info cube.off")["closed"] == true);
}

TEST_CASE("mesh refuses what it cannot use", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  shop.write("empty.off", "");
  shop.write("cut.off", std::string(cube_off).substr(0, 60));
  shop.write("flat.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  shop.write("cut.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1");
  shop.write("notes.txt", "hello\n");
  check_refused(shop, "mesh absent.off -o a.msh", {"absent.off: cannot be read"});
  check_refused(shop, "mesh empty.off -o a.msh", {"empty.off: is empty"});
  check_refused(shop, "mesh cut.off -o a.msh", {"cut.off"});
  check_refused(shop, "mesh flat.off -o a.msh", {"flat.off"});
  check_refused(shop, "mesh cut.msh -o a.msh", {"cut.msh:5: 3 nodes announced, but the file is cut short"});
  check_refused(shop, "mesh notes.txt -o a.msh", {"unknown kind of file"});
  check_refused(shop, "mesh -o a.msh", {"expected a file or --phantom"});
  check_refused(shop, "mesh cube.off --phantom ball -o a.msh", {"expected one of them"});
  check_refused(shop, "mesh --phantom kidney -o a.msh", {"liver, beam, ball, slab"});
  check_refused(shop, "mesh cube.off -o a.vtk", {"ends in .msh or .vtu"});
  check_refused(shop, "mesh cube.off -o none/a.msh", {"does not exist"});
  check_refused(shop, "mesh cube.off -o a.msh --elements=0", {"--elements"});
  check_refused(shop, "mesh cube.off -o a.msh --elements=-5", {"--elements"});
  check_refused(shop, "mesh cube.off -o a.msh --elements=many", {"--elements"});
  check_refused(shop, "mesh cube.off -o a.msh --length=-1", {"--length"});
  check_refused(shop, "mesh cube.off -o a.msh --length=nan", {"--length"});
}

TEST_CASE("mesh and info say where the body lies, and a mesh can be written for ParaView", "[mesh]") {
  const Workshop shop;
  shop.write("cube.off", cube_off);
  const auto made = shop.forefeel("mesh cube.off -o cube.vtu --elements 200");
  CHECK_THAT(made.err + made.out, Contains("within x 0 to 1, y 0 to 1, z 0 to 1 m"));
  CHECK_THAT(shop.forefeel("info cube.vtu").out, Contains("within x 0 to 1, y 0 to 1, z 0 to 1 m"));
  CHECK_THAT(shop.forefeel("info cube.off").out, Contains("within x 0 to 1, y 0 to 1, z 0 to 1 m"));
  const auto info = shop.json("info cube.vtu");
  CHECK(info["volume"] == Approx(1));
  const auto again = shop.json("mesh cube.vtu -o cube.msh");
  CHECK(again["elements"] == info["elements"]);
  CHECK(again["box"] == info["box"]);
}

TEST_CASE("info says that the body in a label volume is small", "[mesh]") {
  const Workshop shop;
  const std::string header = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 2 2\nencoding: ascii\nspacings: ";
  const std::string body = "0 1 1 0 0 1 1 0 0 1 1 0 0 0 0 0\n";  // two voxels long
  shop.write("a.nrrd", header + "0.03 0.02 0.02\n\n" + body);
  CHECK_THAT(shop.forefeel("info a.nrrd").err,
             Contains("a.nrrd: is 6e-05 m long; if its lengths are in m, it is 0.06 m long"));
  shop.write("b.nrrd", header + "30 20 20\n\n" + body);
  CHECK(shop.forefeel("info b.nrrd").err.empty());
}

TEST_CASE("a surface in mm is said to be long, and --unit reads it in its unit", "[mesh]") {
  const Workshop shop;
  std::string large = "OFF\n8 12 0\n";
  for (int i = 0; i < 8; ++i)
    large += std::to_string(300 * (i & 1)) + " " + std::to_string(300 * (i >> 1 & 1)) + " " +
             std::to_string(300 * (i >> 2 & 1)) + "\n";
  const std::string cube = cube_off;
  shop.write("mm.off", large + cube.substr(cube.find("3 0 2 1")));
  const std::string said = "mm.off: is 300 m long; if its lengths are in mm, it is 0.3 m long";
  const auto plain = shop.forefeel("mesh mm.off -o a.msh --elements 200 --json");
  CHECK_THAT(plain.err, Contains(said + "; --unit or --length scales it"));
  REQUIRE(plain.json()["warnings"].size() == 1);
  CHECK_THAT(shop.forefeel("info mm.off").err, Contains(said + "; forefeel mesh --unit"));
  CHECK_THAT(shop.forefeel("info a.msh").err, Contains("is 300 m long"));
  const auto scaled = shop.forefeel("mesh mm.off -o b.msh --elements 200 --unit mm --json");
  CHECK(scaled.json()["volume"] == Approx(0.027));
  CHECK(scaled.json()["hausdorff"].get<double>() < 1e-5);
  CHECK(scaled.json()["warnings"].empty());
  CHECK_THAT(shop.forefeel("mesh mm.off -o e.msh --elements 200 --unit um").err,
             Contains("is 0.0003 m long; if its lengths are in mm, it is 0.3 m long"));
  CHECK(shop.json("mesh a.msh -o c.msh --unit mm")["volume"] == Approx(0.027));
  check_refused(shop, "mesh mm.off -o d.msh --unit inch", {"--unit", "'inch'", "m, cm, mm or um"});
  check_refused(shop, "mesh mm.off -o d.msh --unit mm --length 0.2", {"--unit", "expected one of them"});
  check_refused(shop, "mesh --phantom ball -o d.msh --unit mm", {"--unit", "--length"});
}

TEST_CASE("a mesh that lost volume is said to, with what to do", "[mesh]") {
  const Workshop shop;
  // Two cubes of which one lies in the other and becomes a cavity: together 1.125 m3, filled 0.875 m3.
  std::string inner = "OFF\n16 24 0\n";
  for (const double size : {1.0, 0.5})
    for (int i = 0; i < 8; ++i)
      inner += std::to_string(0.1 * (size < 1) + size * (i & 1)) + " " +
               std::to_string(0.1 * (size < 1) + size * (i >> 1 & 1)) + " " +
               std::to_string(0.1 * (size < 1) + size * (i >> 2 & 1)) + "\n";
  const int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const int first : {0, 8})
    for (const auto& [a, b, c] : faces)
      inner += "3 " + std::to_string(first + a) + " " + std::to_string(first + b) + " " +
               std::to_string(first + c) + "\n";
  shop.write("two.off", inner);
  const auto outcome = shop.run("mesh two.off -o two.msh --elements 300 --json");
  CHECK(outcome.json()["volume_change"] == Approx(0.875 / 1.125 - 1).margin(0.06));
  CHECK_THAT(outcome.err, Contains("% less volume than the surface"));
  CHECK_THAT(outcome.err, Contains("2 parts, and one inside another may become a cavity"));
}

TEST_CASE("a flipped mesh is turned with a warning", "[mesh]") {
  const Workshop shop;
  shop.write("flipped.msh",
             "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 0.1 0 0\n3 0 0.1 0\n4 0 0 "
             "0.1\n$EndNodes\n$Elements\n1\n1 4 2 0 1 1 3 2 4\n$EndElements\n");
  const auto outcome = shop.run("mesh flipped.msh -o turned.msh --json");
  CHECK_THAT(outcome.err, Contains("all tetrahedra were turned"));
  CHECK(outcome.json()["volume"].get<double>() > 0);
  CHECK(shop.json("info turned.msh")["warnings"].empty());
}

TEST_CASE("states go in and out unchanged", "[states]") {
  const Workshop shop;
  shop.write("a.csv", "x,y,z,fx,fy,fz,h\n0,0,0,0,0,0,0.01\n0.01,0,0,-0.125,1e-17,3,0.01\n");
  const auto in = shop.json("import a.csv -o a.states --spacing 0.01");
  CHECK(in["states"] == 2);
  shop.run("import a.csv -o a.states --spacing 0.01 --quiet");  // safe to repeat
  const auto info = shop.json("info a.states");
  CHECK(info["kind"] == "states");
  CHECK(info["states"] == 2);
  CHECK(info["spacing"] == 0.01);
  CHECK(info["by_status"]["measured"] == 2);
  CHECK(info["max_force"] == Approx(std::hypot(0.125, 3)));
  shop.run("export a.states -o b.csv --quiet");
  CHECK(shop.same("a.csv", "b.csv"));
  CHECK(shop.json("export a.csv -o b.vtu")["written"] == 2);
}

TEST_CASE("a recording with names of its own is imported with --columns", "[states]") {
  const Workshop shop;
  shop.write("robot.csv",
             "time,current_pos_x,current_pos_y, current_pos_z,force_x,force_y,force_z,status,time\n"
             "0,10,-20,0.5,1,2,-3,moving,0\n0.1,12,-20,0.5,1.5,2,-3,moving,0.1\n");
  const std::string begin = "import robot.csv -o robot.states --spacing 0.002 --unit mm ";
  const std::string position = "current_pos_x,current_pos_y,current_pos_z";
  shop.run(begin + "--columns " + position + ",force_x,-force_y,force_z --quiet");
  shop.run("export robot.states -o robot-si.csv --quiet");
  CHECK(shop.read("robot-si.csv") ==
        "x,y,z,fx,fy,fz\n0.01,-0.02,0.0005,1,-2,-3\n0.012,-0.02,0.0005,1.5,-2,-3\n");
  check_refused(shop, begin, {"robot.csv:1"});
  check_refused(shop, begin + "--columns current_pos_x,current_pos_y",
                {"--columns", "names 2 columns", "alone"});
  check_refused(shop, begin + "--columns " + position + ",force_x,force_x,force_z",
                {"--columns", "names 6 columns, expected different ones"});
  check_refused(shop, begin + "--columns " + position + ",force_x,force_y,torque",
                {"robot.csv:1", "no column torque", "force_z"});
  check_refused(shop, begin + "--columns time," + position.substr(14) + ",force_x,force_y,force_z",
                {"column time is there twice"});
  check_refused(shop, begin + "--columns status," + position.substr(14) + ",force_x,force_y,force_z",
                {"robot.csv:2", "'moving' is not a number"});
}

TEST_CASE("places alone and a value at each place are imported by the names of their columns", "[states]") {
  const Workshop shop;
  std::string rows = "lon,lat,depth,salt\n";
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      for (int k = 0; k < 5; ++k) rows += fmt::format("{},{},{},{}\n", 10 * i, 10 * j, 10 * k, 3 * i - j);
  shop.write("sea.csv", rows);
  shop.run("import sea.csv -o places.states --columns lon,lat,depth --quiet");
  CHECK_THAT(shop.run("info places.states").out, Contains("spacing 10 m", "no forces"));
  shop.run("import sea.csv -o salt.states --columns lon,lat,depth,-salt --quiet");
  shop.write("asked.csv", "x,y,z\n20,10,30\n");
  // A value is one number by its name, not a force.
  CHECK_THAT(shop.run("evaluate salt.states --points asked.csv --method rbf --no-bars").out,
             Contains("salt = -5") && !Contains(" N"));
  shop.run("evaluate salt.states --points asked.csv --method rbf --no-bars -o out.csv --quiet");
  CHECK_THAT(shop.read("out.csv"), Contains("x,y,z,salt,label\n20,10,30,-5"));
  const auto found = shop.json("evaluate salt.states --points asked.csv --method rbf --no-bars");
  CHECK(found["values"][0] == Approx(-5));
  CHECK_THAT(shop.run("classify salt.states").out, Contains("h = 10 m", " m3 ", "of radius"));
}

TEST_CASE("import, export and info refuse what they cannot use", "[states]") {
  const Workshop shop;
  shop.write("good.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n");
  shop.write("short.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n1,2,3\n");
  shop.write("nan.csv", "x,y,z,fx,fy,fz\n0,0,nan,0,0,0\n");
  shop.write("fake.states", "not a database at all");
  shop.write("empty.states", "");
  check_refused(shop, "import short.csv -o s.states --spacing 0.01", {"short.csv:3: 3 columns, expected 6"});
  check_refused(shop, "import nan.csv -o s.states --spacing 0.01", {"nan.csv:2: column z"});
  check_refused(shop, "import absent.csv -o s.states --spacing 0.01", {"absent.csv"});
  check_refused(shop, "import good.csv -o s.states --spacing=0", {"--spacing"});
  check_refused(shop, "import good.csv -o s.states", {"--spacing"});
  check_refused(shop, "import good.csv -o none/s.states --spacing 0.01", {"does not exist"});
  check_refused(shop, "import good.csv -o fake.states --spacing 0.01", {"is not a state file"});
  check_refused(shop, "export absent.states -o a.csv", {"absent.states: cannot be read"});
  check_refused(shop, "export good.csv -o a.xlsx", {".csv or .vtu"});
  check_refused(shop, "info empty.states", {"is empty"});
  check_refused(shop, "info fake.states", {"fake.states"});
  check_refused(shop, "info absent", {"absent: cannot be read"});
}
