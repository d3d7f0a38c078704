// forefeel session of a scene with contact.anywhere: its files, what it refuses, recorded motions.

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "geometry/common/csv_rows.hpp"
#include "tests/apps/felt_in_table.hpp"
#include "tests/support/executable.hpp"

namespace {

// The beam of 10 x 2 x 2 cm, clamped at x = 0. law: linear, or another.
std::string beam(const std::string& law, const std::string& contact = "") {
  return "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"" + law +
         "\"\nyoung = 5000.0\npoisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n" +
         contact + "[state_space]\ndepth = 0.004\n";
}

}  // namespace

TEST_CASE("a session touches anywhere: columns, labels, errors, states that the next one knows") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean", "friction = 0.3\n"));
  const auto run = shop.run(
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 3 --workers 2 -o run "
      "--json");
  const json said = run.json();
  CHECK(said["frames"] == 3000);
  CHECK(said["touch"]["slid"].get<double>() > 0.01);
  CHECK(said["touch"]["cone"].get<double>() < 1e-3);
  CHECK(said["error"]["samples"].get<int>() > 10);
  CHECK(said["error"]["p50"].get<double>() < 0.001);
  CHECK(said["error"]["within_jnd"].get<double>() > 0.95);
  CHECK(said["touch"]["out_of_cone"].get<double>() < 0.01);
  CHECK(said["touch"]["out_of_cone_longest"].get<double>() < 0.05);
  CHECK(said["switch"]["frames_over_jnd"] == 0);
  CHECK(said["field"]["sites"].get<int>() > 10);
  const CsvTable frames =
      read_csv(shop.path() / "run/frames.csv", std::array<std::string_view, 2>{"x", "fx"});
  CHECK(frames.rows() == 3000);
  const test::FeltInTable felt = test::felt_in(CsvText::read(shop.path() / "run/frames.csv", "a table"));
  CHECK(said["felt_steps"]["count"] == felt.count);
  CHECK(said["felt_steps"]["largest_N"].get<double>() == Approx(felt.largest).margin(1e-12));
  CHECK(said["felt_steps"]["largest_share"].get<double>() == Approx(felt.largest_share).margin(1e-12));
  const std::string text = shop.read("run/frames.csv");
  for (const char* word : {"touch", ",slip,", ",stick,", ",none,", "trusted", "sx,sy,sz"})
    CHECK_THAT(text, Contains(word));
  CHECK_THAT(shop.read("run/report.html"), Contains("Where the hand was"));
  const auto next = shop.run(
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 1 --states "
      "run/session.states -o "
      "again --json");
}

TEST_CASE("a linear body is exact everywhere, without a state") {
  const Workshop shop;
  shop.write("any.toml", beam("linear", "bonded = true\n"));
  const auto run = shop.run(
      "session any.toml --device path:palpation,depth=0.003 --clock virtual --seconds 4 --switch none -o run "
      "--json");
  const json said = run.json();
  CHECK(said["touch"]["count"].get<int>() > 1);
  CHECK(said["states"]["solved"] == 0);
  CHECK(said["touch"]["jets"].get<int>() > 1);
  // Facets are polynomials, near the exact field; where the hand's jet is known the force is exact.
  CHECK(said["error"]["p50"].get<double>() < 1e-6);
  CHECK(said["error"]["p95"].get<double>() < 0.01);
}

TEST_CASE("a pad that is smaller than a facet is said") {
  const Workshop shop;
  shop.write("any.toml", beam("linear"));
  const std::string session =
      "session any.toml --device path:line,depth=0.003 --clock virtual --seconds 0.1 ";
  const std::string usual = shop.json(session + "-o usual")["notes"].dump();
  CHECK_THAT(usual, !Contains("the pad is"));
  const std::string small = shop.json(session + "-o small --set contact.radius=0.004")["notes"].dump();
  CHECK_THAT(small, Contains("the pad is 8 mm across, less than the facets' edges, 11 mm in the mean"));
}

TEST_CASE("a recorded motion is registered by its first sample and the normal") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean"));
  std::string trace = "t,x,y,z\n";
  for (int i = 0; i <= 100; ++i)
    trace += std::to_string(0.01 * i) + ",5,7," + std::to_string(9 - 0.003 * std::sin(0.0314159 * i)) + "\n";
  shop.write("motion.csv", trace);
  const Workshop::Outcome run = shop.forefeel(
      "session any.toml --device trace:motion.csv,register=0.06/0.01/0.03 --clock virtual -o run --json");
  const Workshop::Outcome lifted = shop.forefeel(
      "session any.toml --device trace:motion.csv,register=0.06/0.01/0.03,offset=0/0/0.004 --clock virtual "
      "-o "
      "lifted --json");
  CHECK(lifted.json()["touch"]["count"] == 0);
  CHECK(lifted.json()["notes"][0] == "the tip never entered the body");
  INFO(run.err);
  REQUIRE(run.code == 0);
  CHECK(run.json()["touch"]["count"] == 1);
  const CsvTable frames =
      read_csv(shop.path() / "run/frames.csv", std::array<std::string_view, 3>{"x", "y", "z"});
  double deepest = 1;
  for (std::size_t i = 0; i < frames.rows(); ++i) {
    CHECK(std::abs(frames.at(i, 0) - 0.06) < 1e-9);
    deepest = std::min(deepest, frames.at(i, 2));
  }
  CHECK(deepest == Approx(0.02 - 0.003).margin(1e-5));
}

TEST_CASE("runs, states and arrivals of the other contact are refused, and a folder has one session") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean", "friction = 0.3\n"));
  shop.write("one.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"neo-hookean\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\npad = 400.0\nradius = 0.012\n[state_space]\nspacing = 0.004\n"
             "box = [[-0.008, -0.008, -0.008], [0.008, 0.008, 0.008]]\n");
  const std::string any = "session any.toml --clock virtual --seconds 0.5 ",
                    one = "session one.toml --clock virtual --seconds 0.5 ";
  const json touched = shop.run(any + "--device path:line,depth=0.003 -o touched --json").json();
  CHECK(touched["time_outside"].is_null());  // there is no box
  shop.run(one + "-o grasped --quiet");
  const Workshop::Outcome slippery =
      shop.forefeel("replay touched --scene any.toml --set contact.friction=0.5");
  check_refused(slippery, "replay", {"friction: 0.3 in the record, 0.5 in the scene"});
  CHECK_THAT(slippery.err, !Contains("depth") && !Contains("sha256"));
  check_refused(shop, any + "--replay grasped -o other", {"replay", "holds one place of the body"});
  check_refused(shop, one + "--replay touched -o other", {"replay", "sites", "contact.anywhere"});
  check_refused(shop, one + "--states touched/session.states --foreign -o other",
                {"sites", "contact.anywhere"});
  check_refused(shop, "classify touched", {"touched anywhere", "--scene"});
  shop.write("far.csv", "t,x,y,z\n0,1,1,1\n");
  check_refused(shop, any + "--arrivals far.csv -o other", {"from its place on the surface"});
  shop.write("sited.csv", "t,x,y,z,sx,sy,sz\n0.1,0,0,-0.002,0.06,0.01,0.02\n");
  check_refused(shop, one + "--arrivals sited.csv -o other", {"arrivals", "sites"});
  shop.run(any + "--arrivals sited.csv -o sited --quiet");
  const CsvTable states =
      read_csv(shop.path() / "sited/states.csv", std::array<std::string_view, 3>{"sx", "sy", "sz"});
  REQUIRE(states.rows() == 1);
  CHECK(states.at(0, 2) == Approx(0.02));

  const int held = ::open((shop.path() / "grasped").c_str(), O_RDONLY | O_DIRECTORY);
  REQUIRE(::flock(held, LOCK_EX) == 0);
  const std::string before = shop.read("grasped/session.inputs");
  check_refused(shop, one + "-o grasped", {"grasped", "being written by another session"});
  CHECK(shop.read("grasped/session.inputs") == before);
  ::close(held);
  shop.run(one + "-o grasped --quiet");
}

TEST_CASE("what is for one place is refused, and what is for a surface elsewhere; shapes are for both") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean"));
  shop.write("plain.toml", beam_scene());
  const std::string start = "session any.toml --clock virtual --seconds 1 -o run ";
  check_refused(shop, start + "--device path:circle", {"path:circle", "palpation"});
  check_refused(shop, start + "--device hand:touch,target=reach", {"path:reach", "palpation"});
  // Before the field is made, which would refuse these sites.
  check_refused(shop, start + "--device path:circle --set contact.site_spacing=0.00001",
                {"path:circle", "palpation"});
  check_refused(shop, start + "--device path:line,amplitude=0.01", {"amplitude", "depth"});
  check_refused(shop, start + "--device path:line,where=nowhere", {"where", "nowhere"});
  check_refused(shop, start + "--device path:line,where=5/5/5/0.01", {"where"});
  check_refused(shop, start + "--device hand:touch --policy clairvoyant",
                {"--policy", "depends on the force"});
  check_refused(shop, start + "--switch paper", {"session.switch", "contact.anywhere"});
  const std::string plain = "session plain.toml --clock virtual --seconds 1 -o run ";
  check_refused(shop, plain + "--device path:line,depth=0.003", {"depth", "contact.anywhere"});
  CHECK_FALSE(fs::exists(shop.path() / "run/frames.csv"));
  const json shaped = shop.json(start + "--device path:palpation,depth=0.003 --shape-rate 10");
  CHECK(shaped["shape"]["shapes"] == 10);
  CHECK(shaped["shape"]["error"]["p95"].get<double>() < 0.05);
  CHECK_THAT(text_of(shop.path() / "run/shape.csv"), Contains("t,x,y,z"));
  CHECK(fs::exists(shop.path() / "run/shape.pvd"));
}

TEST_CASE(
    "states with sites in a table: classified, compared with the body at their sites, refused for another",
    SLOW("solves states at many sites")) {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean"));
  shop.write("soft.toml", beam("neo-hookean") + "[session]\nseconds = 1\n");
  shop.write("plain.toml", beam_scene());
  shop.run("generate any.toml -o any.states");
  shop.run("export any.states -o any.csv");
  const std::string session =
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 0.5 ";
  const auto known = shop.run(session + "--states any.csv -o run");
  check_refused(shop, session + "--set material.young=6000 --states any.csv -o other",
                {"any.csv", "of the site", "names no body"});
  check_refused(shop, "session plain.toml --clock virtual --seconds 1 --states any.csv -o no",
                {"any.csv", "contact.anywhere"});
  shop.write("one.csv", "x,y,z,fx,fy,fz\n0,0,-0.001,0,0,0.1\n");
  check_refused(shop, session + "--states one.csv -o no", {"one.csv", "sx,sy,sz"});

  const auto all = shop.run("classify any.states --scene any.toml --json");
  const json said = all.json();
  double sum = 0;
  for (const auto& [label, share] : said["share"].items()) sum += share.get<double>();
  CHECK(sum == Approx(1));
  CHECK(said["states"].get<int>() >= 100);
  CHECK(said["trusted"].get<double>() > 0.9);
  const auto table = shop.run("classify any.csv --scene any.toml -o labels.csv");
  CHECK(read_csv(shop.path() / "labels.csv", std::array<std::string_view, 2>{"sx", "near"}).rows() == 1000);
  // At a site of the field x = 0 is a state, and deep below everything none is near.
  const CsvTable states =
      read_csv(shop.path() / "any.csv", std::array<std::string_view, 3>{"sx", "sy", "sz"});
  const auto at = [&](int k) { return std::to_string(states.at(0, static_cast<std::size_t>(k))); };
  shop.write("points.csv", "sx,sy,sz,x,y,z\n" + at(0) + "," + at(1) + "," + at(2) + ",0,0,0\n" + at(0) + "," +
                               at(1) + "," + at(2) + ",0.05,0.05,0.05\n");
  const auto two = shop.run("classify any.states --scene any.toml --points points.csv");
  CHECK_THAT(two.out, Contains("sparse  trusted"));
  CHECK_THAT(two.out, Contains("blank   not trusted"));
  check_refused(shop, "classify any.states", {"--scene", "contact.anywhere"});
  shop.write("far.csv", "sx,sy,sz,x,y,z\n100,0,0,0,0,0\n");
  for (const char* command : {"classify any.states", "evaluate any.states"})
    check_refused(shop, std::string(command) + " --scene any.toml --points far.csv", {"far.csv", "farther"});
  check_refused(shop, "evaluate any.csv --scene any.toml --set material.young=6000 --points points.csv",
                {"any.csv", "of the site"});
  check_refused(shop, "info any.toml --set contact.radius=1", {"contact.radius", "body"});
  check_refused(shop, "info any.toml --set contact.site_spacing=0.00001", {"contact.site_spacing", "sites"});
  check_refused(shop, "classify any.states --scene any.toml --grid 0.01", {"--grid", "without sites"});
}

TEST_CASE("deeper than the body is thick is said") {
  const Workshop shop;
  shop.write("any.toml", beam("linear"));
  const std::string solve = "solve any.toml --site=0.05,0.01,0.02 --json --at=0,0,";
  const Workshop::Outcome through = shop.forefeel(solve + "-0.021"), within = shop.forefeel(solve + "-0.019");
  CHECK(through.json()["states"][0]["thickness"] == Approx(0.02).epsilon(1e-6));
  CHECK_THAT(through.err, Contains("20 mm thick"));
  CHECK_THAT(within.err, !Contains("thick"));
  shop.write("points.csv", "sx,sy,sz,x,y,z\n0.05,0.01,0.02,0,0,-0.021\n0.05,0.01,0.02,0,0,-0.019\n");
  shop.run("generate any.toml -o any.states");
  const json said = shop.json("evaluate any.states --scene any.toml --points points.csv");
  CHECK(said["through"] == 1);
  REQUIRE(said["forces"][1].size() == 3);
  CHECK(said["forces"][1][2].get<double>() > 0);
  CHECK(said["trusted"] == json({false, true}));
}

TEST_CASE(
    "a hand palpates where nothing else is said; passivity is controlled; a clairvoyant policy knows the "
    "way") {
  const Workshop shop;
  shop.write("any.toml", beam("neo-hookean", "friction = 0.3\n"));
  const auto hand = shop.run(
      "session any.toml --device hand:falcon,speed=0.2 --clock virtual --seconds 2 --set "
      "session.passivity=\\\"control\\\" -o hand --json");
  const json said = hand.json();
  CHECK(said["touch"]["count"].get<int>() > 0);
  CHECK(said["passivity"]["control"] == true);
  CHECK(said["passivity"]["coupling"].get<double>() > 100);
  CHECK(said["passivity"]["lowest_J"].get<double>() >= 0);
  CHECK(said["energy"]["generated_J"].get<double>() < 1e-5);
  const auto best = shop.run(
      "session any.toml --device path:tour,depth=0.003 --clock virtual --seconds 1 --policy clairvoyant -o "
      "best "
      "--json");
  CHECK_THAT(best.json()["notes"].dump(), Contains("clairvoyant: "));
}
