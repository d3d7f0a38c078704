// forefeel evaluate: compared with SciPy from files to forces; difficult sets of states; invalid options.

#include <fmt/format.h>

#include "tests/support/executable.hpp"

namespace {

const fs::path shared_liver = source_folder() / "../shared/data/liver";

double length(const json& v) {
  return std::hypot(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
}

// The whole number that stands before these words.
int number_before(const std::string& text, const std::string& words) {
  const std::size_t end = text.find(words);
  INFO(text);
  REQUIRE(end != std::string::npos);
  return std::stoi(text.substr(text.find_last_not_of("0123456789", end - 1) + 1));
}

// Writes points inside the box of the states whose 100 nearest states are unique, and SciPy's forces there.
constexpr const char* oracle = R"(
import csv, json, sys
import numpy
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
rows = list(csv.DictReader(open("states.csv")))
at = numpy.array([[float(r[k]) for k in ("x", "y", "z")] for r in rows])
force = numpy.array([[float(r[k]) for k in ("fx", "fy", "fz")] for r in rows])
low, high = at.min(0), at.max(0)
points = low + (high - low) * numpy.random.default_rng(3).random((60, 3))
distance, _ = cKDTree(at).query(points, 101)
points = points[distance[:, 100] - distance[:, 99] > 1e-9]
numpy.savetxt("points.csv", points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
answers = {"states": len(at)}
for kernel in ("linear", "cubic"):
    for n in (None, 100):
        field = RBFInterpolator(at, force, neighbors=n, kernel=kernel, degree=1)
        answers[kernel + ("100" if n else "all")] = field(points).tolist()
json.dump(answers, open("answers.json", "w"))
)";

}  // namespace

TEST_CASE("generate, export and evaluate equal SciPy on the liver's states",
          "[scipy]" SLOW("compares with SciPy, which only run.sh all installs")) {
  const Workshop shop;
  if (!has_python_module("scipy.interpolate")) return skip("python3-scipy is not installed");
  std::string scene = "beam.toml --set state_space.spacing=0.002";
  if (fs::exists(shared_liver / "liver_patch.toml"))
    scene = (shared_liver / "liver_patch.toml").string() + " --set state_space.spacing=0.012";
  else
    shop.write("beam.toml", beam_scene());
  shop.json("generate " + scene + " -o l.states --quiet");
  shop.run("export l.states -o states.csv --quiet");
  shop.write("oracle.py", oracle);
  REQUIRE(shop.shell("/usr/bin/python3 oracle.py").code == 0);
  std::ifstream in(shop.path() / "answers.json");
  const json answers = json::parse(in);
  REQUIRE(answers["states"].get<int>() > 100);
  for (const std::string kernel : {"linear", "cubic"})
    for (const std::string n : {"all", "100"}) {
      CAPTURE(scene, kernel, n);
      const auto found =
          shop.json("evaluate l.states --points points.csv --data force --select nearest --kernel " + kernel +
                    " --neighbours " + (n == "all" ? answers["states"].dump() : n));
      const auto& expected = answers[kernel + n];
      REQUIRE(found["forces"].size() == expected.size());
      REQUIRE(expected.size() >= 30);
      double worst = 0;
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const std::vector<double> a = found["forces"][i], b = expected[i];
        worst = std::max(
            worst, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / std::max(length(expected[i]), 0.05));
      }
      CHECK(worst < 1e-9);
    }
}

TEST_CASE("hostile sets of states: every force is finite and below its bound", "[evaluate]") {
  const Workshop shop;
  shop.write("points.csv", "x,y,z\n0,0,0\n0.003,0.001,-0.002\n0.02,-0.01,0.005\n0.3,0.1,-0.2\n1e6,0,0\n");
  const std::string header = "x,y,z,fx,fy,fz\n";
  const std::vector<std::pair<std::string, std::string>> sets = {
      {"one", header + "0.01,0,0,-1,0,0\n"},
      {"two", header + "0.01,0,0,-1,0,0\n0.02,0,0,-2,0,0\n"},
      {"three", header + "0.01,0,0,-1,0,0\n0.02,0,0,-2,0,0\n0,0.01,0,0,-1,0\n"},
      {"four", header + "0.01,0,0,-1,0,0\n0.02,0,0,-2,0,0\n0,0.01,0,0,-1,0\n0,0,0.01,0,0,-1\n"},
      {"at rest",
       header + "0,0,0,0,0,0\n0.006,0,0,0,0,0\n0,0.006,0,0,0,0\n0,0,0.006,0,0,0\n0.006,0.006,0.006,0,0,0\n"},
      {"contradictory", header + "0,0,0,1,0,0\n0,0,0,-1,0,0\n0.006,0,0,1,2,3\n0.006,0,0,-3,2,1\n0.006,1e-9,0,"
                                 "9,9,9\n0,0.006,0,0,0,1\n"
                                 "0,0,0.006,0,1,0\n0.006,0.006,0.006,1,1,1\n"},
      {"one far",
       header + "0,0,0,0,0,0\n0.006,0,0,-1,0,0\n0,0.006,0,0,-1,0\n0,0,0.006,0,0,-1\n1e3,0,0,-5,0,0\n"},
      {"tiny",
       header + "0,0,0,0,0,0\n1e-8,0,0,-1,0,0\n0,1e-8,0,0,-1,0\n0,0,1e-8,0,0,-1\n1e-8,1e-8,1e-8,-1,-1,-1\n"},
      {"huge", header + "0,0,0,0,0,0\n1e5,0,0,-1e9,0,0\n0,1e5,0,0,-1e9,0\n0,0,1e5,0,0,-1e9\n1e5,1e5,1e5,-1e9,"
                        "-1e9,-1e9\n"}};
  for (const auto& [set, text] : sets) {
    shop.write("states.csv", text);
    for (const std::string kernel : {"linear", "cubic", "quintic"})
      for (const std::string more :
           {"", " --select nearest --ridge 0.01", " --neighbours 3 --ridge auto", " --spacing 0.006"}) {
        CAPTURE(set, kernel, more);
        const auto found = shop.json("evaluate states.csv --points points.csv --kernel " + kernel + more);
        REQUIRE(found["forces"].size() == 5);
        for (std::size_t i = 0; i < 5; ++i) {
          for (const auto& component : found["forces"][i])
            REQUIRE(component.is_number());  // null if not finite
          CHECK(length(found["forces"][i]) <= found["force_bounds"][i].get<double>());
        }
      }
  }
}

TEST_CASE("states and options that evaluate refuses", "[evaluate]" SLOW("runs the command fifty times")) {
  const Workshop shop;
  shop.write("points.csv", "x,y,z\n0,0,0\n");
  shop.write("states.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.006,0,0,-1,0,0\n");
  shop.write("nan.csv", "x,y,z,fx,fy,fz\n0,0,0,nan,0,0\n");
  shop.write("nan_points.csv", "x,y,z\nnan,0,0\n");
  shop.write("no_points.csv", "x,y,z\n");
  shop.write("short.csv", "x,y,z,fx,fy\n0,0,0,0,0\n");
  const std::string all = "evaluate states.csv --points points.csv ";
  check_refused(shop, "evaluate nan.csv --points points.csv", {"nan.csv"});
  check_refused(shop, "evaluate short.csv --points points.csv", {"short.csv"});
  check_refused(shop, "evaluate absent.csv --points points.csv", {"absent.csv"});
  check_refused(shop, "evaluate states.csv --points nan_points.csv", {"nan_points.csv"});
  check_refused(shop, "evaluate states.csv --points no_points.csv", {"no_points.csv"});
  check_refused(shop, all + "--data force+stiffness", {"stiffness"});
  check_refused(shop, all + "--kernel linear --data force+stiffness", {"stiffness"});
  check_refused(shop, all + "--ridge -1", {"--ridge"});
  check_refused(shop, all + "--ridge nan", {"--ridge"});
  check_refused(shop, all + "--ridge 1x", {"--ridge", "auto"});
  check_refused(shop, all + "--kernel septic", {"--kernel"});
  check_refused(shop, all + "--method magic", {"--method"});
  check_refused(shop, all + "--method trilinear", {"lattice"});
  check_refused(shop, all + "--spacing 0", {"--spacing"});
  check_refused(shop, all + "-o absent/out.csv", {"absent"});
  check_refused(shop, all + "--neighbours 99999999999999999999", {"--neighbours"});
  check_refused(shop, all + "--neighbours 100001", {"--neighbours", "from 1 to 100000"});
  std::string many = "x,y,z,fx,fy,fz\n";  // too many states for a model in memory
  for (int i = 0; i < 12'000; ++i)
    many += fmt::format("{},{},{},1,2,3\n", 0.001 * (i % 23), 0.001 * (i / 23 % 23), 0.001 * (i / 529));
  shop.write("many.csv", many);
  check_refused(shop, "evaluate many.csv --points points.csv --neighbours 12000",
                {"--neighbours: is 12000", "GB"});
  // An input must not be overwritten.
  for (const std::string file : {"states.csv", "points.csv", "./states.csv"})
    check_refused(shop, all + "-o " + file, {file, "would replace"});
  check_refused(shop, "classify states.csv --spacing 0.006 -o states.csv", {"states.csv", "would replace"});
  shop.run(all + "-o out.csv");  // the inputs are unchanged
  CHECK_THAT(shop.forefeel(all + "--set material.poisson=0.3").err, Contains("--set: without effect"));
  CHECK_THAT(shop.forefeel(all + "--method two-force --select nearest").err,
             Contains("--select: without effect"));
}

TEST_CASE("evaluate, import and info say that states contradict each other, and these are averaged",
          "[evaluate]") {
  const Workshop shop;
  const std::string first = "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,1,0,0\n0,0.01,0,0,1,0\n0,0,0.01,0,0,1\n";
  shop.write("points.csv", "x,y,z\n0.01,0,0\n");
  shop.write("once.csv", first);
  shop.write("same.csv", first + "0,0.01,0,0,1,0\n");
  shop.write("other.csv", first + "0,0.01,0,0,1,0\n0.01,0,0,2,0,0\n0.01,0,0,-3,0,0\n");
  for (const std::string states : {"once.csv", "same.csv", "other.csv"})
    for (const std::string& command : {"evaluate " + states + " --points points.csv", "info " + states,
                                       "import " + states + " -o " + states + ".states --spacing 0.01"}) {
      const auto outcome = shop.run(command + " --json --quiet");
      const bool differ = states == "other.csv";
      const std::string warning =
          "warning: " + states +
          ": 2 states contradict another at the same position: averaged at 1 position, "
          "where forces differ by up to 5 N\n";
      CHECK((outcome.err.find(warning) != std::string::npos) == differ);
      CHECK(outcome.json()["averaged"] == (differ ? 1 : 0));
      CHECK(outcome.json()["largest_difference"] == Approx(differ ? 5 : 0));
      if (command.starts_with("evaluate"))
        CHECK(outcome.json()["forces"][0][0] == Approx(differ ? 0 : 1).margin(1e-9));
      else
        CHECK(outcome.json()["contradicting"] == (differ ? 2 : 0));
    }
  shop.write("single.csv", first + "0,0.01,0,0,2,0\n");
  for (const std::string command : {"evaluate single.csv --points points.csv", "info single.csv"})
    CHECK_THAT(shop.forefeel(command).err, Contains("1 state contradicts another at the same position"));
}

TEST_CASE(
    "evaluate --method auto says what it chose and the error to expect; it is the default of forces alone",
    "[evaluate]" SLOW("chooses a model several times")) {
  const Workshop shop;
  std::string states = "x,y,z,fx,fy,fz\n", stiff = "x,y,z,fx,fy,fz,k11,k12,k13,k21,k22,k23,k31,k32,k33\n";
  for (int i = 0; i < 125; ++i) {
    const double x = 0.01 * (i % 5), y = 0.01 * (i / 5 % 5), z = 0.01 * (i / 25);
    const std::string row =
        fmt::format("{},{},{},{},{},{}", x, y, z, -20 * x, -30 * y, -25 * z - 400 * z * z);
    states += row + "\n";
    stiff += row + fmt::format(",20,0,0,0,30,0,0,0,{}\n", 25 + 800 * z);
  }
  shop.write("states.csv", states);
  shop.write("stiff.csv", stiff);
  shop.write("points.csv", "x,y,z\n0.013,0.022,0.017\n0.035,0.005,0.024\n");
  const json open = shop.json("evaluate states.csv --points points.csv"),
             asked = shop.json("evaluate states.csv --points points.csv --method auto");
  CHECK(open["forces"] == asked["forces"]);
  CHECK(open["method"] == "auto");
  for (const char* key : {"kernel", "neighbours", "ridge"})
    CHECK(open["chosen"][key] == asked["chosen"][key]);
  CHECK(open["chosen"]["kernel"] == open["kernel"]);
  CHECK(open["expected_error"]["p50"].get<double>() <= open["expected_error"]["p95"].get<double>());
  CHECK(open["forces"][0][2] == Approx(-25 * 0.017 - 400 * 0.017 * 0.017).epsilon(0.02));
  const json kept = shop.json("evaluate states.csv --points points.csv --method auto --kernel linear");
  CHECK(kept["chosen"]["kernel"] == "linear");
  for (const std::string& other :
       {std::string("evaluate states.csv --kernel cubic"), std::string("evaluate stiff.csv"),
        std::string("evaluate states.csv --method rbf")}) {
    const json plain = shop.json(other + " --points points.csv");
    CHECK(plain["method"] == "rbf");
    CHECK(plain["chosen"].is_null());
    CHECK(plain["expected_error"].is_null());
  }
  const json both = shop.json("evaluate stiff.csv --method auto --points points.csv");
  CHECK(both["chosen"]["data"] == "force+stiffness");
  CHECK_THAT(shop.forefeel("evaluate states.csv --points points.csv").out,
             Contains("expected error p50", "comparisons with known forces, left out in "));
  // For places outside, states at the border are left out more than once: more comparisons than the 125 states.
  shop.write("outside.csv", "x,y,z\n0.055,0.02,0.02\n-0.012,0.02,0.03\n0.02,0.055,0.01\n0.02,0.02,0.055\n");
  const std::string told = shop.forefeel("evaluate states.csv --points outside.csv").out;
  CHECK(number_before(told, " comparisons with known forces") > 125);
}

TEST_CASE("the time of a fit is that of models that were made, and their number is told",
          "[evaluate]" SLOW("fits models at thousands of points")) {
  const Workshop shop;
  std::string states = "x,y,z,fx,fy,fz\n", points = "x,y,z\n";
  for (const int i : {0, 1, 2, 3, 4, 5})
    for (const int j : {0, 1, 2, 3, 4, 5})
      for (const int k : {0, 1, 2, 3, 4, 5})
        states += fmt::format("{},{},{},{},{},{}\n", 0.01 * i, 0.01 * j, 0.01 * k, i + 0.3 * j * k,
                              j - 0.2 * i * i, k);
  for (int p = 0; p < 9; ++p) points += fmt::format("{},0.024,0.026\n", 0.012 + 0.004 * p);
  shop.write("states.csv", states);
  shop.write("points.csv", points);
  shop.write("point.csv", "x,y,z\n0.024,0.024,0.026\n");
  const std::string all = "evaluate states.csv --kernel cubic --select nearest --points ";
  // All states in each model: one is made, and it serves every point.
  const json same = shop.json(all + "points.csv --neighbours 216");
  CHECK(same["fitted"] == 1);
  CHECK(same["updated"] == 0);
  CHECK(same["reused"] == 8);
  // With far fewer neighbours the sets differ, and each point has its own model.
  const json moving = shop.json(all + "points.csv --neighbours 12");
  CHECK(moving["fitted"].get<int>() + moving["updated"].get<int>() + moving["reused"].get<int>() == 9);
  CHECK(moving["fitted"].get<int>() > 4);
  const json lattice = shop.json(all + "points.csv --method trilinear");
  CHECK(lattice["fitted"] == 1);
  CHECK(lattice["reused"] == 8);
  CHECK_THAT(
      shop.forefeel(
              "evaluate states.csv --points points.csv --kernel cubic --neighbours 216 --select nearest")
          .out,
      Contains("models: 1 fitted, 8 reused; medians: fit"));
}

TEST_CASE("evaluate says of every method what it uses, and keeps it below its bound", "[evaluate]") {
  const Workshop shop;
  std::string states = "x,y,z,fx,fy,fz\n";
  for (const int i : {0, 1})
    for (const int j : {0, 1})
      for (const int k : {0, 1})
        states += fmt::format("{},{},{},{},{},{}\n", 0.01 * i, 0.01 * j, 0.01 * k, i + 0.3 * j * k,
                              j - 0.2 * i * i, k);
  shop.write("states.csv", states);
  shop.write("points.csv", "x,y,z\n0.004,0.005,0.006\n0.14,0.1,-0.03\n-3,2,1\n");
  const std::string all = "evaluate states.csv --points points.csv --method ";
  const auto uses = [&](const std::string& method) {
    const json json = shop.json(all + method);
    for (std::size_t i = 0; i < 3; ++i) {
      INFO(method << " at point " << i);
      CHECK(length(json["forces"][i]) <= (1 + 1e-12) * json["force_bounds"][i].get<double>());
    }
    std::vector<std::string> said;
    for (const char* key : {"kernel", "data", "neighbours", "centres", "select", "ridge"})
      said.push_back(json.at(key).is_null() ? "-" : json.at(key).dump());
    return fmt::format("{}", fmt::join(said, " "));
  };
  CHECK(uses("rbf --kernel linear --neighbours 6") == R"("linear" "force" 6 - "label" 0.0)");
  CHECK(uses("offline-rbf --kernel linear --neighbours 6") == R"("linear" "force" - - - 0.0)");
  CHECK(uses("rbf-network") == R"("cubic" "force" - 8 - -)");
  CHECK(uses("rbf-network --neighbours 5") == R"("cubic" "force" - 5 - -)");
  for (const std::string method : {"trilinear", "tricubic", "deflection", "two-force"})
    CHECK(uses(method) == R"(- "force" - - - -)");
  shop.write("corner.csv", "x,y,z\n0.004,0.004,0.004\n0.002,0.001,0.001\n0.008,0,0\n");
  shop.write("cell.csv",
             "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.004,0,0,-1,0,0\n0,0.004,0,0,-1,0\n0,0,0.004,0,0,-1\n"
             "0.004,0.004,0,-1,-1,0\n0.004,0,0.004,-1,0,-1\n0,0.004,0.004,0,-1,-1\n"
             "0.004,0.004,0.004,-1,-1,-1\n0.008,0,0,-2,0,0\n");
  for (const std::string method : {"trilinear", "tricubic"})
    CHECK_THAT(shop.forefeel("evaluate cell.csv --spacing 0.004 --points corner.csv --method " + method).err,
               Contains("no full lattice cell holds 1 of 3 points"));
  CHECK_THAT(shop.forefeel(all + "trilinear --kernel cubic --ridge 1").err, Contains("--kernel, --ridge"));
}

TEST_CASE("evaluate says where the kernel stepped down", "[evaluate]") {
  const Workshop shop;
  std::string plane = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 25; ++i)
    plane += fmt::format("{},{},0,{},{},{}\n", 0.006 * (i % 5), 0.006 * (i / 5), i, i * i, 1);
  shop.write("plane.csv", plane);
  shop.write("block.csv", plane + "0.01,0.01,0.006,1,2,3\n0.02,0.01,0.006,1,2,4\n0.01,0.02,-0.006,2,2,3\n");
  shop.write("points.csv", "x,y,z\n0.01,0.01,0.001\n0.004,0.005,0\n");
  const std::string cubic = " --points points.csv --kernel cubic --data force";
  const json flat = shop.json("evaluate plane.csv" + cubic), whole = shop.json("evaluate block.csv" + cubic);
  CHECK(flat["kernels"] == json{"linear with constant", "linear with constant"});
  CHECK(flat["stepped_down"] == 2);
  CHECK(whole["kernels"] == json{"cubic", "cubic"});
  CHECK(whole["stepped_down"] == 0);
}

TEST_CASE("evaluate says which forces of jets are trusted", "[evaluate]") {
  const BeamShop shop;
  shop.run("generate beam.toml -o j.states --set state_space.jet=4");
  shop.write("q.csv", "x,y,z\n0.001,0.0005,0\n0.2,0.2,0\n");
  const json said = shop.json("evaluate j.states --points q.csv --data jet -o forces.csv");
  CHECK(said["data"] == "jet");
  CHECK(said["trusted"] == json({true, false}));
  const std::string rows = shop.read("forces.csv");
  CHECK_THAT(rows, Contains("label,trusted", ",safe,1", ",blank,0"));
  const std::string text = shop.forefeel("evaluate j.states --points q.csv --data jet").out;
  CHECK_THAT(text, Contains("safe, trusted", "blank, not trusted"));
  CHECK(shop.json("evaluate j.states --points q.csv")["trusted"].is_null());
  const std::string unused =
      shop.forefeel("evaluate j.states --points q.csv --data jet --kernel cubic --noise 0.1").err;
  CHECK_THAT(unused, Contains("--kernel: without effect", "--noise: without effect"));
  shop.run("export j.states -o j.csv --quiet");
  check_refused(shop, "import j.csv -o k.states --spacing 0.01 --unit mm",
                {"--unit: is for states without energy jets"});
}
