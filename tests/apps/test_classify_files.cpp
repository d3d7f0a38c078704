// The files that forefeel classify writes for ParaView.

#include "geometry/coverage/setups.hpp"
#include "tests/apps/vtk_files.hpp"

namespace {

constexpr double h = 0.006;

std::string csv(const std::vector<Vec3>& states) {
  std::ostringstream text;
  text.precision(17);
  text << "x,y,z,fx,fy,fz\n";
  for (const Vec3& p : states) text << p.x() << ',' << p.y() << ',' << p.z() << ",0,0,0\n";
  return text.str();
}

std::string setup_csv(std::string_view name) {
  return csv(make_setup(name, {.depth = 3, .half_width = 4}).states);
}

// States scattered over a cube of 10 cm, which give many components of every label.
std::vector<Vec3> strewn() {
  std::vector<Vec3> states;
  for (int i = 1; i < 160; ++i)
    states.push_back(0.1 * Vec3(std::fmod(i * 0.8191725134, 1), std::fmod(i * 0.6710436067, 1),
                                std::fmod(i * 0.5497004779, 1)));
  return states;
}

}  // namespace

TEST_CASE("the files of classify open in VTK, with labels whose volumes are those reported",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  const json report = shop.json("classify gap.csv --spacing 0.006 -o out.vtu");
  const json seen = read_by_vtk(shop, "out.vtu out_states.vtu out_cells.vtu");
  if (seen.is_null()) return;
  const json &regions = seen[0], &states = seen[1], &cells = seen[2];
  CHECK(regions["types"] == json({11}));
  CHECK(regions["cells"] >= report["leaves"]);
  const char* labels[] = {"safe", "sparse", "gap", "blank"};
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(regions["volume"].value(std::to_string(i), 0.0) ==
          Approx(report["volume"][labels[i]].get<double>()).margin(1e-15));
  CHECK(regions["cell_data"]["component"]["size"] == regions["cells"]);
  CHECK(regions["cell_data"]["safe_components"]["max"] == 2);
  CHECK(regions["cell_data"]["bridge_sides"]["max"] == 2);
  CHECK(states["points"] == report["states"]);
  CHECK(cells["types"] == json({10}));
  // In full cubes the spread at a cell's centroid stays below half the diagonal; across the gap it is larger.
  CHECK(cells["cell_data"]["spread"]["min"].get<double>() < std::sqrt(3.0) / 2 * h);
  CHECK(cells["cell_data"]["spread"]["max"].get<double>() > 2 * h);
  CHECK(cells["cell_data"]["alpha"]["min"] == Approx(std::sqrt(3.0) / 2 * h));
}

TEST_CASE("in the .vtu of regions, what is connected over points are the components, and labels have names",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  shop.write("strewn.csv", csv(strewn()));
  for (const std::string command : {"gap.csv --spacing 0.006", "strewn.csv --spacing 0.012",
                                    "strewn.csv --spacing 0.012 --index octree"}) {
    INFO(command);
    const json report = shop.json("classify " + command + " -o out.vtu");
    const json seen = read_by_vtk(shop, "out.vtu");
    if (seen.is_null()) return;
    const char* labels[] = {"safe", "sparse", "gap", "blank"};
    for (std::size_t i = 0; i < 4; ++i) CHECK(seen[0]["parts"][i] == report["components"][labels[i]]);
    CHECK(seen[0]["points"].get<double>() < 4 * seen[0]["cells"].get<double>());
    CHECK(seen[0]["named_otherwise"] == 0);
  }
}

TEST_CASE("the .vtu of states holds no array of values that are not known",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("four.csv", csv({{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}));
  shop.run("classify four.csv --spacing 0.01 -o out.vtu");
  const json seen = read_by_vtk(shop, "out_states.vtu");
  if (seen.is_null()) return;
  const json& data = seen[0]["point_data"];
  CHECK(data["force"]["max"] == 0);
  CHECK(data.contains("status"));
  for (const char* array :
       {"stiffness", "energy", "spacing", "residual", "seconds", "min_jacobian", "parent"}) {
    INFO(array);
    CHECK_FALSE(data.contains(array));
  }
}
