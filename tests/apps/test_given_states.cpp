// States given to a command: the file is only read. States of another body are refused or taken as foreign, and never
// mixed with solves of the scene's body.

#include <fmt/format.h>

#include "apps/picture/plot.hpp"
#include "geometry/common/csv_rows.hpp"
#include "geometry/common/quantiles.hpp"
#include "geometry/common/types.hpp"
#include "tests/support/executable.hpp"

namespace {

// beam.toml, its lattice in beam.states, the same as a CSV, and the CSV with forces three times as large.
void prepare(const Workshop& shop) {
  shop.write("beam.toml", beam_scene());
  shop.run("generate beam.toml -o beam.states --quiet");
  shop.run("export beam.states -o same.csv --quiet");
  REQUIRE(shop.shell("awk -F, 'BEGIN {OFS=\",\"} NR == 1 {print \"x,y,z,fx,fy,fz\"; next} "
                     "{print $1, $2, $3, 3 * $4, 3 * $5, 3 * $6}' same.csv > other.csv")
              .code == 0);
  shop.run("import same.csv -o same.states --spacing 0.004 --quiet");
  shop.run("import other.csv -o other.states --spacing 0.004 --quiet");
}

// The rows of a table by the names of their columns; an empty cell is left out.
std::vector<std::map<std::string, double>> rows_of(std::istream& in) {
  std::vector<std::string> names;
  std::vector<std::map<std::string, double>> rows;
  for (std::string line, cell; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream cells(line);
    const bool header = names.empty();
    if (!header) rows.emplace_back();
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i)
      if (header)
        names.push_back(cell);
      else if (!cell.empty() && names[i] != "label")
        rows.back()[names[i]] = std::stod(cell);
  }
  return rows;
}

const std::string at_rest = "session beam.toml --seconds 0.4 --quiet ";
const std::string session =
    at_rest + "--clock virtual --cost constant:0.01 --device path:circle,speed=0.06,amplitude=0.007 ";
// More positions than the given states have.
const std::string wide = session + "--set 'state_space.box=[[-0.008,-0.008,-0.008],[0.008,0.008,0.008]]' ";

}  // namespace

TEST_CASE("a file given with --states is read only; what is solved goes to the run's own file", "[states]") {
  const Workshop shop;
  prepare(shop);
  for (const std::string file : {"beam.states", "same.states", "same.csv"}) {
    CAPTURE(file);
    const std::string before = shop.read(file);
    const json summary = shop.json(wide + "--states " + file + " -o run-" + file);
    CHECK(shop.read(file) == before);
    CHECK(summary["states"]["start"] == 27);
    CHECK(summary["states"]["solved"].get<int>() > 0);
    CHECK(summary["states"]["foreign"] == false);
    CHECK(summary["error"]["samples"].get<int>() > 0);
    const json kept = shop.json("info run-" + file + "/session.states");
    CHECK(kept["states"] == summary["states"]["solved"]);
    CHECK(kept["identity"] == shop.json("info beam.states")["identity"]);
  }
  check_refused(shop, session + "--states absent.states -o run", {"absent.states"});
  check_refused(shop, session + "--states run-same.csv/session.states -o run-same.csv",
                {"session.states", "--extend"});
}

TEST_CASE("--extend appends what is solved to the given file, of the same body alone", "[states]") {
  const Workshop shop;
  prepare(shop);
  const json summary = shop.json(wide + "--states beam.states --extend -o run");
  CHECK(summary["states"]["solved"].get<int>() > 0);
  CHECK(shop.json("info beam.states")["states"] == 27 + summary["states"]["solved"].get<int>());
  CHECK_THAT(shop.files(), !Contains("run/session.states"));
  const json made = shop.json(wide + "--states new.states --extend -o run-2");
  CHECK(shop.json("info new.states")["states"] == made["states"]["solved"]);
  check_refused(shop, wide + "--states same.states --extend -o run-3", {"same.states", "name no body"});
  check_refused(shop, wide + "--states same.csv --extend -o run-3", {"same.csv"});
  check_refused(shop, wide + "--extend -o run-3", {"--extend", "--states"});
  check_refused(shop, wide + "--states beam.states --extend --foreign -o run-3", {"--foreign", "--extend"});
  check_refused(shop, "generate beam.toml -o same.states", {"same.states", "name no body"});
}

TEST_CASE("states without a body that do not fit the scene's are refused, with the differences", "[states]") {
  const Workshop shop;
  prepare(shop);
  shop.write("points.csv", "x,y,z\n0.001,0.001,0.001\n");
  for (const std::string file : {"other.states", "other.csv"})
    for (const std::string& command : {session + "--states " + file + " -o run",
                                       "classify " + file + " --calibrate beam.toml -o calibration",
                                       "evaluate " + file + " --scene beam.toml --points points.csv",
                                       "classify " + file + " --scene beam.toml"})
      check_refused(shop, command, {file, "names no body", "the forces differ at", "those of the body"});
  shop.run("classify other.csv --scene beam.toml --foreign --quiet");
  // A file in millimetres: positions so far out are not solved.
  shop.write("mm.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n4,0,0,-1,0,0\n0,4,0,0,-1,0\n0,0,4,0,0,-1\n");
  check_refused(shop, session + "--states mm.csv -o run", {"mm.csv", "from rest"});
  CHECK(shop.json("evaluate same.csv --scene beam.toml --points points.csv")["belonging"] == "asked");
  CHECK(shop.json("evaluate beam.states --scene beam.toml --points points.csv")["belonging"] == "identity");
  CHECK(shop.json("evaluate other.csv --foreign --scene beam.toml --points points.csv")["belonging"] ==
        "foreign");
  CHECK(shop.json("evaluate other.csv --points points.csv")["belonging"].is_null());
}

TEST_CASE("the picture of a calibration obeys --palette", "[states]") {
  const Workshop shop;
  prepare(shop);
  const std::string command = "classify other.csv --calibrate beam.toml --foreign ";
  shop.json(command + "-o usual");
  shop.json(command + "-o grey --palette grey");
  if (!forefeel::have_gnuplot()) return skip("gnuplot is not installed");
  const std::string usual = shop.read("usual/calibration.svg"), grey = shop.read("grey/calibration.svg");
  CHECK_THAT(usual, Contains("213,  94,   0") && !Contains(" 77,  77,  77"));
  CHECK_THAT(grey, Contains(" 77,  77,  77") && !Contains("213,  94,   0"));
  check_refused(shop, command + "-o other --palette mine", {"--palette", "okabe-ito"});
}

TEST_CASE("labels of foreign states are calibrated with a part of them left out, and nothing is solved",
          "[states]") {
  const Workshop shop;
  prepare(shop);
  const json found = shop.json("classify other.csv --calibrate beam.toml --foreign -o foreign");
  CHECK(found["truth"] == "left out");
  CHECK_THAT(shop.read("foreign/report.html"), Contains("left out (nothing is solved)"));
  int positions = 0;
  for (const char* label : {"safe", "sparse", "gap", "blank"})
    positions += found["positions"][label].get<int>();
  const int sets = int(found["sets"].size());
  CHECK(positions > 0);
  CHECK(positions <= 27 / 5 * sets);
  CHECK(shop.json("classify other.csv --calibrate beam.toml --foreign")["table"] == found["table"]);
  CHECK(shop.json("classify same.csv --calibrate beam.toml")["truth"] == "solved");
  shop.write("few.csv",
             "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.004,0,0,-9,0,0\n0,0.004,0,0,-9,0\n0,0,0.004,0,0,-9\n"
             "0,0.004,0.004,0,-9,-9\n");
  check_refused(shop, "classify few.csv --calibrate beam.toml --foreign", {"few.csv", "at least 20"});
  check_refused(shop, "classify --calibrate beam.toml --foreign", {"--foreign", "STATES"});
}

TEST_CASE("a foreign session renders the given states alone: nothing is solved, and the summary says so",
          "[states]") {
  const Workshop shop;
  prepare(shop);
  shop.run("generate beam.toml -o soft.states --quiet --set material.young=1000");
  check_refused(shop, session + "--states soft.states -o run", {"soft.states", "material", "--foreign"});
  for (const std::string clock : {"virtual", "real"})
    for (const std::string file : {"other.states", "other.csv", "soft.states"}) {
      CAPTURE(clock, file);
      const std::string out = "run-" + clock + file, before = shop.read(file);
      const json summary = shop.json(at_rest + "--device path:circle --clock " + clock + " --states " + file +
                                     " --foreign --cost recorded --set session.rest_known=true -o " + out);
      CHECK(summary["states"]["foreign"] == true);
      CHECK(summary["states"]["start"] == 27);
      CHECK(summary["states"]["solved"] == 0);
      CHECK(summary["error"]["samples"] == 0);
      CHECK(summary["error"]["p95"].is_null());
      CHECK(summary["first_guess"] == false);
      CHECK_THAT(summary["notes"].dump(), Contains("of another body"));
      CHECK(shop.read(file) == before);
      CHECK_THAT(shop.files(), !Contains(out + "/session.states"));
      CHECK(std::ranges::count(shop.read(out + "/states.csv"), '\n') == 28);
    }
  // The rendered force is that of the given states, three times the body's.
  const std::string force = "awk -F, 'END {print sqrt($5^2+$6^2+$7^2)}' ";
  const std::string slow =
      at_rest + "--clock virtual --device path:circle,speed=0.02,amplitude=0.003 --states ";
  CHECK(shop.json(slow + "same.csv -o same")["error"]["samples"].get<int>() > 0);
  shop.json(slow + "other.csv --foreign -o three");
  CHECK(std::stod(shop.shell(force + "three/frames.csv").out) ==
        Approx(3 * std::stod(shop.shell(force + "same/frames.csv").out)).epsilon(0.1));
  shop.write("arrivals.csv", "t,x,y,z\n0.1,0.004,0,0\n");
  check_refused(shop, session + "--states other.csv --foreign --arrivals arrivals.csv -o run",
                {"foreign", "mixed"});
  check_refused(shop, session + "--foreign -o run", {"--foreign", "--states"});
}

// 25 presses of 20 rows with noise of 0.02 N and 1 um. A model through the rows takes the noise across a press for a
// slope of 20,000 N/m.
TEST_CASE("a session on measured forces renders their field, and its bars are those of the field",
          "[states]" SLOW("fits fields of hundreds of rows")) {
  const BeamShop shop;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto force = [](const forefeel::Vec3& x) {
    return forefeel::Vec3(-80 * x[0], -80 * x[1], -300 * x[2] * (1 - 60 * x[2]));
  };
  std::string rows = "x,y,z,fx,fy,fz\n";
  for (int place = 0; place < 25; ++place)
    for (int i = 0; i < 20; ++i) {
      const forefeel::Vec3 x(0.006 * (place % 5 - 2), 0.006 * (place / 5 - 2), -0.012 + 0.0012 * i);
      const forefeel::Vec3 f = force(x);
      const auto off = [&](double size) { return size * normal(random); };
      rows += fmt::format("{},{},{},{},{},{}\n", x[0] + off(1e-6), x[1] + off(1e-6), x[2] + off(1e-6),
                          f[0] + off(0.02), f[1] + off(0.02), f[2] + off(0.02));
    }
  shop.write("presses.csv", rows);
  const auto told = shop.run(
      "session beam.toml --seconds 1 --clock virtual --states presses.csv --foreign "
      "--device path:lissajous,amplitude=0.008 -o run");
  CHECK_THAT(told.out + told.err, Contains("their field", "of 500 places"));
  std::ifstream frames(shop.path() / "run/frames.csv");
  const std::vector<std::map<std::string, double>> all = rows_of(frames);
  REQUIRE(all.size() == 1000);
  std::vector<double> errors;
  int held = 0;
  for (std::size_t i = 100; i < all.size(); ++i) {  // the force has faded in
    const auto vector = [&](const char* a, const char* b, const char* c) {
      return forefeel::Vec3(all[i].at(a), all[i].at(b), all[i].at(c));
    };
    errors.push_back(
        (vector("rendered_x", "rendered_y", "rendered_z") - force(vector("x", "y", "z"))).norm());
    held += errors.back() <= all[i].at("bar95");
  }
  CHECK(forefeel::quantile_of(errors, 0.95) < 0.05);  // 27 N by a model through the rows
  CHECK(held >= 0.93 * double(errors.size()));
}

// A new user's stroke: f = -100 x along 2 cm, asked along it and 5 mm beside it.
TEST_CASE("the report of a session on a measured stroke begins with the distance of the hand and its cost",
          "[states]" SLOW("fits fields of hundreds of rows")) {
  const BeamShop shop;
  std::string rows = "pos_x,pos_y,pos_z,force_x,force_y,force_z\n", on = "t,x,y,z\n", beside = on, left = on;
  for (int i = 0; i < 200; ++i) {
    const double x = -10 + 20 * i / 199.0;  // [mm]
    const double noise = 0.01 * std::sin(7.7 * i * i);
    rows += fmt::format("{},0,0,{},{},0\n", x, -0.1 * x + noise, 0.01 * std::cos(3.1 * i * i));
  }
  for (int i = 0; i <= 10; ++i) {
    on += fmt::format("{},{},0,0\n", 0.1 * i, -0.008 + 0.0016 * i);
    beside += fmt::format("{},{},0.005,0\n", 0.1 * i, -0.008 + 0.0016 * i);
    left += fmt::format("{},{},{},0\n", 0.1 * i, -0.008 + 0.0016 * i, i < 6 ? 0 : 0.004 * (i - 5));
  }
  shop.write("stroke.csv", rows);
  shop.write("on.csv", on);
  shop.write("beside.csv", beside);
  shop.write("left.csv", left);
  shop.run(
      "import stroke.csv -o stroke.states --unit mm --spacing 0.002 --quiet "
      "--columns pos_x,pos_y,pos_z,force_x,force_y,force_z");
  shop.run("classify stroke.states -o map.svg --quiet");
  const auto away = [&](const std::string& motion) {
    const json summary = shop.json(
        "session beam.toml --seconds 1 --quiet --clock virtual --states stroke.states "
        "--foreign --device trace:" +
        motion + ".csv -o run-" + motion);
    CHECK_THAT(summary["attention"][0].get<std::string>(),
               Catch::StartsWith("the hand was ") &&
                   Contains("% of the time, where the states tell the force within",
                            "from the nearest known place"));
    const std::string page = shop.read("run-" + motion + "/report.html");
    CHECK(page.find("the hand was ") < page.find("class=\"tiles\""));
    json found = summary["away_from_states"];
    found["line"] = summary["attention"][0];
    return found;
  };
  const json along = away("on"), off = away("beside"), half = away("left");
  // The first line speaks of the worst part of the time, as the rows of frames.csv have it.
  const CsvText frames = CsvText::read(shop.path() / "run-left/frames.csv", "frames");
  std::map<std::string, std::vector<double>> bars;
  for (std::size_t row = 0; row < frames.rows(); ++row)
    bars[std::string(frames.text(row, "label"))].push_back(frames.number(row, "bar95"));
  std::string worst;
  double widest = 0;
  for (auto& [label, widths] : bars) {
    std::ranges::sort(widths);
    const double p95 = widths[static_cast<std::size_t>(std::lround(0.95 * double(widths.size() - 1)))];
    if (p95 > widest) worst = label, widest = p95;
  }
  CHECK(half["worst_label"] == worst);
  CHECK(half["worst_error_bar"] == Approx(widest));
  CHECK(half["worst_share"] == Approx(double(bars[worst].size()) / double(frames.rows())));
  std::vector<double> rest;
  for (const auto& [label, widths] : bars)
    if (label != worst) rest.insert(rest.end(), widths.begin(), widths.end());
  std::ranges::sort(rest);
  REQUIRE(rest.size() > 2);
  CHECK(half["rest_error_bar"] == Approx(rest[rest.size() / 2]));
  CHECK_THAT(half["line"].get<std::string>(),
             Contains(fmt::format("against {:.2g} N in the rest of it (median)",
                                  half["rest_error_bar"].get<double>())));
  CHECK(half["worst_error_bar"].get<double>() > 3 * half["error_bar"].get<double>());
  CHECK(along["max"].get<double>() < 1e-4);
  CHECK(along["error_bar"].get<double>() < 0.05);
  CHECK(off["p50"] == Approx(0.005).epsilon(0.02));
  CHECK(off["max"].get<double>() < 0.0052);
  // Across the stroke the force is not known: at least its largest stiffness along it, times the distance.
  CHECK(off["error_bar"].get<double>() > 0.5);
  CHECK(off["error_bar"].get<double>() > 20 * off["error_bar_at_states"].get<double>());
  const json known = shop.json(session + "-o solved");
  CHECK(known["away_from_states"]["p50"].is_null());
  CHECK_THAT(known["attention"].dump(), !Contains("the hand was"));
}
