// Reports: the worst moments of a session with reasons, cards that mark bad values, tables that fit the page, figures
// as files.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/picture/palette.hpp"
#include "apps/session/bad_moments.hpp"
#include "apps/session/bars_card.hpp"
#include "apps/session/run_data.hpp"
#include "geometry/common/error.hpp"
#include "tests/support/executable.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/skip.hpp"

using namespace forefeel;
using test::beam_scene;
using test::file_text;
using test::Workshop;

namespace {

// A frame at x = t [mm] whose rendered force is 1 N and whose reference is 1 N + error.
FrameRecord frame(double t, double error) {
  FrameRecord f{.t = t, .at = Vec3(1e-3 * t, 0, 0), .force = Vec3::UnitX(), .sent = Vec3::UnitX()};
  f.judged = {.sampled = true, .first_visit = false, .reference = (1 + error) * Vec3::UnitX()};
  f.judged.error = error / (1 + error);
  f.judged.approximation = f.judged.error;
  f.judged.switching = f.judged.staleness = 0;
  return f;
}

SessionResult result_with(const std::vector<FrameRecord>& frames) {
  SessionResult result;
  result.frames = frames;
  return result;
}

const RunView view{.box = {Vec3::Constant(-0.1), Vec3::Constant(0.1)}, .spacing = 0.004, .force_limit = 5};

}  // namespace

TEST_CASE("the worst moments are the samples above the JND, the worst first, a quarter of a second apart") {
  const SessionResult result =
      result_with({frame(0, 0.01), frame(1, 0.5), frame(1.1, 0.6), frame(2, 0.2), frame(3, 0.06)});
  const std::vector<BadMoment> moments = bad_moments(result, view);
  REQUIRE(moments.size() == 2);
  CHECK(moments[0].t == 1.1);
  CHECK(moments[0].jnds == Approx(0.6 / (0.07 * 1.6)));
  CHECK(moments[0].reference == Approx(1.6));
  CHECK(moments[1].t == 2);
  CHECK(bad_moments(result, view, 1).size() == 1);
}

TEST_CASE("the card of the error bars is bad where a level falls short by more than five points") {
  SessionSummary::ErrorBars bars;
  CHECK(bars_card(bars).judged == Judged::plain);
  bars.all.samples = 400;
  bars.all.inside = {0.905, 0.953, 0.991};
  CHECK(bars_card(bars).judged == Judged::good);
  CHECK(bars_card(bars).value == "95.3 %");
  bars.by_label[Label::gap].samples = 100;
  bars.by_label[Label::gap].inside = {0.90, 0.90, 0.97};  // five points, not more
  CHECK(bars_card(bars).judged == Judged::warn);
  bars.by_label[Label::gap].inside = {0.90, 0.89, 0.97};
  CHECK(bars_card(bars).judged == Judged::bad);
  CHECK_THAT(bars_card(bars).what, Catch::Contains("gap 90.0/89.0/97.0 % of 100"));
  bars.by_label[Label::gap].samples = 99;  // too few to judge a label by
  CHECK(bars_card(bars).judged == Judged::good);
  bars.all.inside[2] = 0.93;
  CHECK(bars_card(bars).judged == Judged::bad);
  bars.all.samples = 19;
  CHECK(bars_card(bars).judged == Judged::plain);
}

TEST_CASE(
    "a bad moment says what was known near the tip, which state came too late, and which part was largest") {
  SessionResult result = result_with({frame(2, 0.5)});
  CHECK_THAT(bad_moments(result, view)[0].why, Catch::StartsWith("No state was known.") &&
                                                   Catch::Contains("No nearer one was asked for") &&
                                                   Catch::Contains("Largest part: approximation"));
  DispatchRecord far{.id = 1, .at = Vec3(0.022, 0, 0)}, late{.id = 2, .at = Vec3(0.003, 0, 0)};
  far.finished = far.known = 1;
  late.requested = 1.5;
  late.finished = late.known = 2.25;
  far.status = late.status = DispatchStatus::solved;
  result.dispatch = {far, late};
  result.frames[0].known = 1;
  CHECK_THAT(
      bad_moments(result, view)[0].why,
      Catch::StartsWith("The nearest of 1 known states was 20 mm away. A state 1 mm away was asked for "
                        "0.5 s before and came 0.25 s too late."));
  result.dispatch[1].started = 2;
  CHECK_THAT(bad_moments(result, view)[0].why,
             Catch::Contains("asked for 0.5 s before, waited 0.5 s for a free worker, took 0.25 s to solve "
                             "and came 0.25 s too late."));
  result.frames[0].judged.staleness = 1;
  result.frames[0].at = Vec3(0.2, 0, 0);
  CHECK_THAT(bad_moments(result, view)[0].why,
             Catch::Contains("outside the box") && Catch::Contains("Largest part: staleness"));
}

TEST_CASE("the data of the curves hold every frame of a short run, and at most 60,000 of a long one") {
  std::vector<FrameRecord> frames;
  for (int i = 0; i < 130'000; ++i) frames.push_back(frame(1e-3 * i, i % 1000 == 0 ? 0.1 : unknown));
  const auto long_run = nlohmann::json::parse(run_data(result_with(frames), view));
  CHECK(long_run["frames"] == 43'334);
  CHECK(long_run["samples"].size() == 130);
  CHECK(long_run["columns"].get<std::string>().size() == (43'334u * 8 * 4 + 2) / 3 * 4);
  frames.resize(1001);
  const auto run = nlohmann::json::parse(run_data(result_with(frames), view));
  CHECK(run["frames"] == 1001);
  CHECK(run["end"] == Approx(1.0));
  CHECK(run["limit"] == 5.0);
  CHECK(run["clamped"].empty());
  CHECK(run["samples"][1][0] == 1.0);
  CHECK(run["samples"][1][1].get<double>() == Approx(1.1));
  CHECK(run["columns"].get<std::string>().substr(0, 10) == "AAAAAG8Sgz");  // 0 and 0.001 as floats
}

TEST_CASE(
    "a session's report: bad cards are marked, headlines have their samples, no raw JSON runs out of it") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene("[session.limits]\nforce = 0.02\n"));
  REQUIRE(shop.forefeel("session beam.toml --clock virtual --seconds 1 --cost constant:0.02 --device "
                        "path:press,speed=0.02 -o run --quiet")
              .code == 0);
  const std::string page = file_text(shop, "run/report.html");
  CHECK_THAT(page, Catch::Contains("<div class=\"tile bad\"><b>"));
  CHECK_THAT(page, Catch::Contains("of 1000 frames clamped at 0.02 N"));
  CHECK_THAT(page, Catch::Contains("load: states that the motion needs"));
  CHECK_THAT(page, Catch::Contains("<h3>prediction.kalman</h3>") && Catch::Contains("<th>horizon [s]</th>") &&
                       Catch::Contains("<th>p95 [m]</th>"));
  CHECK_THAT(page, !Catch::Contains("{&quot;horizon") && !Catch::Contains("{\"horizon"));
  for (const char* headline : {"<h2>Force, label and error over time (", "<h2>Around one switch (",
                               "<h2>Where the errors were (", "<h2>Error by label ("})
    CHECK_THAT(page, Catch::Contains(headline));
  const std::size_t begin = page.find("id=\"run-data\">") + 14;
  const auto data = nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  CHECK(data["frames"] == 1000);
  CHECK_FALSE(data["clamped"].empty());
  CHECK_FALSE(data["samples"].empty());

  const auto summary = nlohmann::json::parse(file_text(shop, "run/summary.json"));
  const std::size_t samples = summary["error"]["samples"];
  REQUIRE(data["samples"].size() > samples);
  CHECK_THAT(page, Catch::Contains(fmt::format("over time ({} samples, {} more at first visits)", samples,
                                               data["samples"].size() - samples)));
  const int ending = summary["loop"]["ending_frames"];
  REQUIRE(ending > 0);
  CHECK_THAT(page, Catch::Contains(fmt::format("in the last {} frames it shrinks to zero", ending)));
}

TEST_CASE("a palette is a known name or a list of colours; another text is refused") {
  CHECK(palette_from_text("grey").size() > 3);
  CHECK(palette_from_text("#010203,#aBcDeF") == Palette{"#010203", "#aBcDeF"});
  CHECK(colour_of(Palette{"a", "b"}, 3) == "b");
  for (const char* bad : {"", "gray-ish", "#12345", "#gg0000"})
    CHECK_THROWS_AS(palette_from_text(bad), InputError);
}

TEST_CASE(
    "a study's report: the verdict and what to do next come first, ties are one place, figures become "
    "files") {
  const Workshop shop;
  shop.write("beam.toml", beam_scene("[session]\nseconds = 0.4\ncost = \"constant:0.01\"\n"));
  shop.write("study.toml",
             "scene = \"beam.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n"
             "device = [\"path:circle,speed=0.03\", \"path:line,speed=0.03\"]\nworkers = [1, 2]\n");
  const std::string command = "study study.toml -o out --quiet --figures pdf,svg --palette '#123456,#fedcba'";
  const Workshop::Outcome run = shop.forefeel(command);
  if (!test::has_command("gnuplot")) {
    CHECK(run.code == 1);
    test::skip("gnuplot is not installed");
    return;
  }
  INFO(run.err);
  REQUIRE(run.code == 0);
  const std::string page = file_text(shop, "out/report.html");
  const std::size_t verdict = page.find("class=\"verdict"), devices = page.find("<h2>Devices</h2>");
  REQUIRE(verdict != std::string::npos);
  CHECK(verdict < devices);
  CHECK_THAT(page, Catch::Contains("motions and seeds)</h2>") && Catch::Contains("energy given back [mJ]") &&
                       Catch::Contains("clamped [%]"));
  CHECK_THAT(shop.files(), Catch::Contains("out/figures/ranking-policy-0.pdf") &&
                               Catch::Contains("out/figures/over-workers.svg"));
  CHECK_THAT(file_text(shop, "out/figures/ranking-policy-0.pdf"), Catch::StartsWith("%PDF"));
  CHECK_THAT(file_text(shop, "out/figures/over-workers.svg"), Catch::Contains("18,  52,  86"));
  const Workshop::Outcome gantt = shop.forefeel("study study.toml -o out --quiet --gantt 1");
  REQUIRE(gantt.code == 0);
  CHECK_THAT(file_text(shop, "out/cell-0001/gantt.svg"),
             Catch::Contains("half: never used") && Catch::Contains(">safe<"));
  const std::string summary = file_text(shop, "out/cell-0001/summary.json");
  CHECK(nlohmann::json::parse(summary)["discretisation_error"].get<double>() >
        0);  // measured, not "not measured"
  REQUIRE(shop.forefeel("study study.toml -o out --quiet --gantt 1 --palette grey --figures pdf").code == 0);
  CHECK_THAT(file_text(shop, "out/cell-0001/gantt.svg"), Catch::Contains("47,  47,  47"));  // grey's safe
  CHECK_THAT(file_text(shop, "out/cell-0001/gantt.pdf"), Catch::StartsWith("%PDF"));
  test::check_refused(shop, "study study.toml -o new --figures gif", {"--figures", "gif", "svg, png, pdf"});
  test::check_refused(shop, "study study.toml -o new --palette mine", {"--palette", "okabe-ito"});
}

TEST_CASE("the picture of classify has the same size in SVG and PNG") {
  if (!test::has_command("gnuplot")) {
    test::skip("gnuplot is not installed");
    return;
  }
  const Workshop shop;
  shop.write("s_1.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,0,0\n0,0.02,0,0,-1,0\n0,0,0.01,0,0,-1\n");
  REQUIRE(shop.forefeel("classify s_1.csv --spacing 0.006 -o c.svg --quiet").code == 0);
  REQUIRE(shop.forefeel("classify s_1.csv --spacing 0.006 -o c.png --quiet").code == 0);
  const std::string png = file_text(shop, "c.png"), svg = file_text(shop, "c.svg");
  const auto size_at = [&](std::size_t byte) {  // of the header, high byte first
    return static_cast<unsigned char>(png[byte + 2]) * 256 + static_cast<unsigned char>(png[byte + 3]);
  };
  REQUIRE(png.size() > 24);
  CHECK_THAT(svg, Catch::Contains("width=\"" + std::to_string(size_at(16)) + "\" height=\"" +
                                  std::to_string(size_at(20)) + "\""));
  CHECK_THAT(svg, Catch::Contains("Coverage of s_1.csv"));
}

TEST_CASE("the picture of classify has room for long numbers at its axes") {
  const Workshop shop;
  const auto width_of = [&](const std::string& box) {
    REQUIRE(shop.forefeel("classify s.csv --spacing 0.006 --box=" + box + " -o c.svg --quiet").code == 0);
    const std::string svg = file_text(shop, "c.svg");
    CHECK_THAT(svg, Catch::Contains("component") && !Catch::Contains(" part"));
    return std::stoi(svg.substr(svg.find("width=\"") + 7));
  };
  shop.write("s.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,0,0\n0,0.02,0,0,-1,0\n0,0,0.01,0,0,-1\n");
  const int usual = width_of("0,0,0:0.01,0.02,0.01");
  CHECK(width_of("0,-0.0002494,0:0.01,0.02,0.01") == usual + 4 * 8 * 2);  // -0.2494: two letters more
}

TEST_CASE("a session's figures become files; a palette colours them, its report and classify's pictures") {
  if (!test::has_command("gnuplot")) {
    test::skip("gnuplot is not installed");
    return;
  }
  const Workshop shop;
  shop.write("beam.toml", beam_scene());
  const std::string session =
      "session beam.toml --clock virtual --seconds 0.5 --device path:circle,speed=0.04 --cost constant:0.02 "
      "--quiet ";
  REQUIRE(shop.forefeel(session + "-o usual").code == 0);
  REQUIRE(shop.forefeel(session + "-o run --figures pdf,svg --palette grey").code == 0);
  CHECK(!std::filesystem::exists(shop.path() / "usual/figures"));
  for (const char* name : {"time", "slice"}) {
    CHECK_THAT(file_text(shop, std::string("run/figures/") + name + ".pdf"), Catch::StartsWith("%PDF"));
    CHECK_THAT(file_text(shop, std::string("run/figures/") + name + ".svg"), Catch::Contains("<svg"));
  }
  CHECK_THAT(file_text(shop, "run/report.html"), Catch::Contains("#2f2f2f") && !Catch::Contains("#0b4f7d"));
  CHECK_THAT(file_text(shop, "usual/report.html"), Catch::Contains("#0b4f7d") && Catch::Contains("#57a7d6"));
  const std::string classify = "classify run/session.states --quiet -o ";
  REQUIRE(shop.forefeel(classify + "c.svg --palette '#010203,#040506,#070809'").code == 0);
  CHECK_THAT(file_text(shop, "c.svg"), Catch::Contains("#010203") && Catch::Contains("#070809"));
  REQUIRE(shop.forefeel(classify + "c.pdf --palette bright").code == 0);
  CHECK_THAT(file_text(shop, "c.pdf"), Catch::StartsWith("%PDF"));
  test::check_refused(shop, session + "-o none --palette mine", {"--palette", "okabe-ito"});
  CHECK(!std::filesystem::exists(shop.path() / "none"));
}
