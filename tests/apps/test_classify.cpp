// forefeel classify: options, files as read by other programs, a run over time, differences, bad input.

#include "geometry/coverage/setups.hpp"
#include "tests/apps/vtk_files.hpp"
#include "tests/support/executable.hpp"

namespace {

constexpr double h = 0.006;

std::string csv(const std::vector<Vec3>& states) {
  std::string text = "x,y,z,fx,fy,fz\n";
  for (const Vec3& p : states) {
    std::ostringstream line;
    line.precision(17);
    line << p.x() << ',' << p.y() << ',' << p.z() << ",0,0,0\n";
    text += line.str();
  }
  return text;
}

std::string setup_csv(std::string_view name) {
  return csv(make_setup(name, {.depth = 3, .half_width = 4}).states);
}

}  // namespace

TEST_CASE("classify reports volumes, gaps with sides and safe parts, fill distance and hole", "[classify]") {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  for (const std::string index : {"delaunay", "octree"}) {
    INFO(index);
    const auto outcome = shop.run("classify gap.csv --spacing 0.006 --json --agreement --index " + index);
    const json report = outcome.json();
    double all = 0;
    for (const char* label : {"safe", "sparse", "gap", "blank"}) all += report["volume"][label].get<double>();
    const Setup setup = make_setup("gap", {.depth = 3, .half_width = 4});
    CHECK(all == Approx(setup.box.size().prod()));
    CHECK(report["components"]["safe"] == 2);
    const json bridge = report["gaps"][0];
    CHECK(bridge["safe_components"].size() == 2);
    REQUIRE(bridge["sides"].size() == 2);
    // One side in each direction along x. The angle between their mean directions depends on the leaf.
    const double a = bridge["sides"][0]["direction"][0], b = bridge["sides"][1]["direction"][0];
    CHECK(a * b < (index == "delaunay" ? -0.9 : 0.0));
    CHECK(report["fill_distance"] == Approx(1e-3 * std::sqrt(24.0 * 24 + 18)).epsilon(2e-3));
    CHECK(report["fill_distance"].get<double>() <= report["fill_distance_bound"].get<double>());
    CHECK(report["fill_distance_bound"].get<double>() <= report["fill_distance"].get<double>() + 0.1 * h);
    CHECK(report["largest_hole"]["radius"] == Approx(1e-3 * std::sqrt(24.0 * 24 + 18)).epsilon(1e-3));
    CHECK(report["agreement"]["share"].get<double>() >= 0.95);
    CHECK(report["peak_bytes"].get<double>() > 1e6);
  }
}

TEST_CASE("classify labels points, lines and grids", "[classify]") {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  shop.write("q.csv", "x,y,z\n-0.003,0.001,0.001\n0.004,0.001,0.001\n0.024,0.001,0.001\n0.2,0,0\n");
  const json points = shop.json("classify gap.csv --spacing 0.006 --points q.csv");
  CHECK(points["labels"] == json({"safe", "sparse", "gap", "blank"}));
  CHECK(points["gamma_deg"][0].is_null());
  CHECK(points["gamma_deg"][2].get<double>() < 85);
  CHECK(points["delta"][2] == Approx(1e-3 * std::hypot(24.0, 1.0, 1.0)));
  CHECK(points["spread"][3].is_null());
  const json line =
      shop.json("classify gap.csv --spacing 0.006 --line -0.01,0.0017,0.0023:0.05,0.0017,0.0023:61");
  REQUIRE(line["labels"].size() == 61);
  CHECK(line["labels"][10] == "safe");
  CHECK(line["labels"][11] == "sparse");
  const json grid = shop.json("classify gap.csv --spacing 0.006 --grid 0.012 -o grid.csv");
  const std::string rows = shop.read("grid.csv");
  CHECK(static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')) == grid["labels"].size() + 1);
  // Thresholds: with a longer distance for sparse, the sparse rim covers the gap.
  const json wide = shop.json("classify gap.csv --spacing 0.006 --sparse-distance 5 --points q.csv");
  CHECK(wide["labels"][2] == "sparse");
  CHECK(wide["volume"]["gap"] == 0);
}

TEST_CASE("pictures hold three slices, four classes of their own hatching and a legend", "[classify]") {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  shop.run("classify gap.csv --spacing 0.006 -o out.svg --through 0.01,0,0");
  const std::string svg = shop.read("out.svg");
  for (const char* part :
       {"x = 10 mm", "y = 0 mm", "z = 0 mm", "class=\"safe\"", "class=\"sparse\"", "class=\"gap\"",
        "safe: ", "blank: ", "states", "pattern id=\"gap\"", "shape-rendering=\"crispEdges\"", "</svg>"})
    CHECK_THAT(svg, Contains(part));
  shop.run("classify gap.csv --spacing 0.006 --index octree -o out.csv");
  CHECK(shop.read("out.csv").starts_with("x,y,z,dx,dy,dz,label,component\n"));
  const auto png = shop.forefeel("classify gap.csv --spacing 0.006 -o out.png");
  if (!has_command("gnuplot")) {
    CHECK(png.code == 2);
    return skip("gnuplot is not installed");
  }
  REQUIRE(png.code == 0);
  CHECK(shop.read("out.png").starts_with("\x89PNG"));
}

TEST_CASE("--diff says from which label to which, in volumes and in a file",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  shop.write("blank.csv", setup_csv("blank"));
  shop.write("gap.csv", setup_csv("gap"));
  const json same = shop.json("classify --diff gap.csv gap.csv --spacing 0.006");
  CHECK(same["diff"]["changed"] == 0);
  const auto outcome = shop.run("classify --diff blank.csv gap.csv --spacing 0.006 -o diff.vtu --json");
  const json diff = outcome.json()["diff"];
  CHECK(diff["worse"] == Approx(0).margin(1e-15));  // only states were added
  CHECK(diff["from_to"]["blank"]["gap"].get<double>() > 1e-6);
  CHECK(diff["better"] == Approx(diff["changed"].get<double>()));
  const json back = shop.json("classify --diff gap.csv blank.csv --spacing 0.006")["diff"];
  CHECK(back["worse"] == Approx(diff["better"].get<double>()));
  const json seen = read_by_vtk(shop, "diff.vtu");
  if (seen.is_null()) return;
  CHECK(seen[0]["cell_data"].contains("label_before"));
  CHECK(seen[0]["cell_data"].contains("label_after"));
  CHECK_FALSE(seen[0]["cell_data"].contains("component"));
  CHECK(seen[0]["cell_data"]["label_before"]["max"] == 3);
}

TEST_CASE("a run becomes a series over time that grows with its states",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const Workshop shop;
  const Setup setup = make_setup("full", {.depth = 2, .half_width = 2, .width = 0.012});
  fs::create_directories(shop.path() / "run");
  std::string frames = "t,x,y,z,fx,fy,fz,label,model,known\n",
              dispatch =
                  "id,x,y,z,label,priority,requested,started,finished,first_used,status,worker,parent\n";
  for (int i = 0; i <= 100; ++i)
    frames += std::to_string(0.01 * i) + "," + std::to_string(1e-4 * i) + ",0,0,0,0,0,blank,0,0\n";
  for (std::size_t i = 0; i < setup.states.size(); ++i) {
    const Vec3& p = setup.states[i];
    dispatch += std::to_string(i) + "," + std::to_string(p.x()) + "," + std::to_string(p.y()) + "," +
                std::to_string(p.z()) + ",blank,1,0,0," +
                std::to_string(0.9 * double(i) / double(setup.states.size())) + ",,solved,0,\n";
  }
  shop.write("run/frames.csv", frames);
  shop.write("run/dispatch.csv", dispatch);
  const auto outcome = shop.run("classify run --spacing 0.006 --snapshots 5 --json");
  const json report = outcome.json();
  REQUIRE(report["snapshots"].size() == 5);
  for (std::size_t i = 1; i < 5; ++i) {
    CHECK(report["snapshots"][i]["volume"]["safe"] >= report["snapshots"][i - 1]["volume"]["safe"]);
    CHECK(report["snapshots"][i]["states"] > report["snapshots"][i - 1]["states"]);
  }
  CHECK(report["snapshots"][4]["label"] == "safe");
  const std::string series = shop.read("run/coverage.pvd");
  CHECK_THAT(series, Contains("timestep=\"1\""));
  for (const char* part : {"regions_00004.vtu", "states_00004.vtu", "hip_00004.vtu"}) {
    CHECK_THAT(series, Contains(part));
    CHECK(fs::exists(shop.path() / "run/coverage_series" / part));
  }
  const json seen =
      read_by_vtk(shop, "run/coverage_series/regions_00004.vtu run/coverage_series/states_00004.vtu");
  if (!seen.is_null()) CHECK(seen[1]["points"] == setup.states.size());
}

TEST_CASE("a series carries forces of states and HIP, and its end is what the run's states give",
          "[classify]" SLOW("compares with VTK, which only run.sh all installs")) {
  const BeamShop shop;
  shop.run("session beam.toml --clock virtual --cost constant:0.02 --seconds 1 --quiet -o run");
  const auto outcome = shop.run("classify run --snapshots 3 --json");
  const json report = outcome.json();
  CHECK(report["spacing"] == 0.004);
  const json once = shop.forefeel("classify run/session.states --json --box " +
                                  [&] {
                                    const json box = shop.json("classify run/session.states")["box"];
                                    std::string text;
                                    for (const auto& corner : box)
                                      text += (text.empty() ? "" : ":") + corner[0].dump() + "," +
                                              corner[1].dump() + "," + corner[2].dump();
                                    return text;
                                  }())
                        .json();
  for (const char* label : {"safe", "sparse", "gap", "blank"})
    CHECK(report["volume"][label] == Approx(once["volume"][label].get<double>()).margin(1e-15));
  const json seen =
      read_by_vtk(shop, "run/coverage_series/states_00002.vtu run/coverage_series/hip_00002.vtu");
  if (seen.is_null()) return;
  for (const json& file : seen) CHECK(file["point_data"]["force"]["max"].is_number());
}

TEST_CASE("built-in sets bring their boxes: blank is blank beyond its slab, holes may have blank middles",
          "[classify]" SLOW("labels every built-in set")) {
  const Workshop shop;
  const json blank = shop.json("classify setup:blank");
  CHECK(blank["volume"]["blank"].get<double>() > 4e-4);
  CHECK(blank["largest_hole"]["radius"] == Approx(std::sqrt(3.0) / 2 * h));
  CHECK(shop.json("classify --diff setup:blank setup:full")["diff"]["worse"] == 0);
  shop.write("wide.csv", csv(make_setup("gap", {.depth = 2, .half_width = 3, .width = 0.120}).states));
  for (const std::string index : {"delaunay", "octree"}) {
    const json wide = shop.json("classify wide.csv --spacing 0.006 --index " + index);
    CHECK(wide["volume"]["blank"].get<double>() > 1e-5);
    CHECK(wide["largest_hole"]["radius"] == Approx(1e-3 * std::sqrt(60.0 * 60 + 18)).epsilon(1e-3));
  }
}

TEST_CASE("the agreement is that of both regions, and nothing is worst where nothing differs", "[classify]") {
  const Workshop shop;
  for (const std::string name : {"sparse", "full"}) {
    const json report = shop.json("classify setup:" + name + " --agreement");
    const json other = shop.json("classify setup:" + name + " --index octree");
    for (const char* d : {"safe", "sparse", "gap", "blank"}) {
      double delaunay = 0, octree = 0;
      for (const char* o : {"safe", "sparse", "gap", "blank"}) {
        delaunay += report["agreement"]["volume_delaunay_octree"][d][o].get<double>();
        octree += report["agreement"]["volume_delaunay_octree"][o][d].get<double>();
      }
      CHECK(delaunay == Approx(report["volume"][d].get<double>()).margin(1e-12));
      CHECK(octree == Approx(other["volume"][d].get<double>()).margin(1e-12));
    }
    CHECK(report["agreement"]["worst"].is_null() == (name == "full"));
    if (const json& worst = report["agreement"]["worst"]; !worst.is_null())
      CHECK(worst["delaunay"] != worst["octree"]);
    // Of holes of one size either may be named.
    CHECK(report["largest_hole"]["radius"] ==
          Approx(other["largest_hole"]["radius"].get<double>()).epsilon(1e-12));
    CHECK(report["fill_distance"] == Approx(other["fill_distance"].get<double>()).epsilon(1e-12));
    CHECK(report["agreement"]["share"].get<double>() >= 0.95);
    CHECK(report["gaps"].size() + report["gaps_left_out"].get<std::size_t>() ==
          report["components"]["gap"].get<std::size_t>());
    // Small gaps in a thinned area touch the safe parts beside them, not all safe parts.
    for (const json& gap : report["gaps"])
      CHECK(gap["safe_components"].size() < report["components"]["safe"].get<std::size_t>());
  }
}

TEST_CASE("states of another body, or of another spacing, are not compared silently", "[classify]") {
  const BeamShop shop;
  const std::string scene = "beam.toml";
  shop.run("session " + scene + " --clock virtual --cost constant:0.02 --seconds 0.3 --quiet -o run");
  shop.run("classify run/session.states --scene " + scene + " --quiet");
  check_refused(shop, "classify run/session.states --scene " + scene + " --set material.young=6000",
                {"session.states", "another body", "material"});
  check_refused(shop, "classify run --scene " + scene + " --set material.young=6000",
                {"run", "another body", "material"});
  shop.run("session " + scene +
           " --clock virtual --cost constant:0.02 --seconds 0.3 --quiet -o wide --set "
           "state_space.spacing=0.002");
  check_refused(shop, "classify --diff run/session.states wide/session.states", {"--diff", "--spacing"});
  check_refused(shop, "classify run --known wide/session.states", {"--known", "--spacing"});
}

TEST_CASE("options that would have no effect, and values that mean nothing, are refused", "[classify]") {
  const Workshop shop;
  shop.write("gap.csv", setup_csv("gap"));
  check_refused(shop, "classify gap.csv --known gap.csv", {"--known", "RUN/"});
  check_refused(shop, "classify gap.csv --snapshots 3", {"--snapshots", "RUN/"});
  check_refused(shop, "classify gap.csv --set material.poisson=0.4", {"--set", "--scene"});
  check_refused(shop, "classify gap.csv --through 0,0,0 -o out.csv", {"--through", "picture"});
  check_refused(shop, "classify gap.csv --box 0,0,0:1,1,0", {"--box", "no volume"});
  check_refused(shop, "classify gap.csv --safe-angle 120", {"--safe-angle", "90"});
  check_refused(shop, "classify gap.csv --safe-angle nan", {"--safe-angle"});
  check_refused(shop, "classify gap.csv --gap-angle nan", {"--gap-angle"});
  check_refused(shop, "classify gap.csv --through 1,0,0 -o out.svg", {"--through", "outside"});
  check_refused(shop, "classify gap.csv --spacing 1e153", {"--spacing"});
  check_refused(shop, "classify --diff gap.csv gap.csv --grid 0.01", {"--grid"});
}

TEST_CASE("states with spacings of their own are labelled by them", "[classify]") {
  const Workshop shop;
  // A lattice of 12 mm, and one octant of it at 6 mm.
  std::string text = "x,y,z,fx,fy,fz,h\n";
  for (int k = -4; k <= 4; ++k)
    for (int j = -4; j <= 4; ++j)
      for (int i = -4; i <= 4; ++i) {
        const bool fine = i >= 0 && j >= 0 && k >= 0, coarse = i % 2 == 0 && j % 2 == 0 && k % 2 == 0;
        if (fine || coarse)
          text += std::to_string(h * i) + "," + std::to_string(h * j) + "," + std::to_string(h * k) +
                  ",0,0,0," + (fine ? "0.006" : "0.012") + "\n";
      }
  shop.write("adaptive.csv", text);
  shop.write("q.csv", "x,y,z\n-0.013,-0.014,-0.015\n0.0131,0.0142,0.0153\n");
  const json own = shop.json("classify adaptive.csv --points q.csv");
  CHECK(own["adaptive"] == true);
  CHECK(own["labels"] == json({"safe", "safe"}));
  CHECK(own["volume"]["safe"] == Approx(std::pow(0.048, 3)));
  const json fine = shop.json("classify adaptive.csv --spacing 0.006 --points q.csv");
  CHECK(fine["adaptive"] == false);
  CHECK(fine["labels"] == json({"sparse", "safe"}));
}

TEST_CASE("strange states are labelled or refused in one line", "[classify]") {
  const Workshop shop;
  shop.write("one.csv", csv({Vec3(0.01, 0, 0)}));
  shop.write("row.csv", csv({Vec3(0, 0, 0), Vec3(0.006, 0, 0), Vec3(0.012, 0, 0), Vec3(0.018, 0, 0)}));
  shop.write("sheet.csv", csv({Vec3(0, 0, 0), Vec3(0.006, 0, 0), Vec3(0, 0.006, 0), Vec3(0.006, 0.006, 0),
                               Vec3(0.012, 0, 0)}));
  shop.write("twice.csv", csv({Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0.006, 0, 0), Vec3(0.006, 0, 0)}));
  for (const std::string index : {"delaunay", "octree"})
    for (const char* file : {"one.csv", "row.csv", "sheet.csv", "twice.csv"}) {
      INFO(file << " " << index);
      const auto outcome = shop.run(std::string("classify ") + file + " --spacing 0.006 --json --index " +
                                    index + " --box=-0.02,-0.02,-0.02:0.03,0.02,0.02 --agreement");
      const json report = outcome.json();
      CHECK(report["volume"]["safe"] == 0);
      CHECK(report["volume"]["sparse"].get<double>() > 0);
    }
  std::vector<Vec3> far = make_setup("full", {.depth = 2, .half_width = 2, .width = 0.012}).states;
  const double near_volume = [&] {
    shop.write("near.csv", csv(far));
    return shop.json("classify near.csv --spacing 0.006")["volume"]["safe"].get<double>();
  }();
  for (Vec3& p : far) p += Vec3(1000, -1000, 1000);
  shop.write("far.csv", csv(far));
  CHECK(shop.json("classify far.csv --spacing 0.006")["volume"]["safe"] == Approx(near_volume).epsilon(1e-6));

  shop.write("empty.csv", "x,y,z,fx,fy,fz\n");
  shop.write("nan.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\nnan,0,0,0,0,0\n");
  shop.write("wide.csv", csv({Vec3(0, 0, 0), Vec3(10, 10, 10)}));
  check_refused(shop, "classify empty.csv --spacing 0.006", {"empty.csv"});
  check_refused(shop, "classify nan.csv --spacing 0.006", {"nan.csv:3"});
  check_refused(shop, "classify one.csv", {"--spacing"});
  check_refused(shop, "classify wide.csv --spacing 0.001", {"--spacing"});
  check_refused(shop, "classify near.csv --spacing 1e-9", {"--spacing"});
  check_refused(shop, "classify near.csv --spacing 0.006 --grid 1e-6", {"--grid"});
  check_refused(shop, "classify near.csv --spacing 0.006 --box 0,0,0:-1,1,1", {"--box"});
  check_refused(shop, "classify near.csv --spacing 0.006 --line 0,0,0:1,1,1:1", {"--line"});
  check_refused(shop, "classify near.csv --spacing 0.006 -o out.obj", {".vtu"});
  check_refused(shop, "classify near.csv --spacing 0.006 --sparse-distance 0.5", {"sparse"});
  check_refused(shop, "classify --diff near.csv", {"--diff"});
  check_refused(shop, "classify near.csv --spacing 0.006 --diff near.csv one.csv", {"--diff"});
}
