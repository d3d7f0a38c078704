// Reports: the worst moments of a session with reasons, cards that mark bad values, tables that fit the page, figures
// as files.

#include <fmt/format.h>

#include "apps/picture/palette.hpp"
#include "apps/session/bad_moments.hpp"
#include "apps/session/bars_card.hpp"
#include "apps/session/run_charts.hpp"
#include "tests/support/executable.hpp"

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
  CHECK_THAT(bars_card(bars).what, Contains("gap 90.0/89.0/97.0 % of 100"));
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
  CHECK_THAT(bad_moments(result, view)[0].why,
             Catch::StartsWith("No state was known.") &&
                 Contains("No nearer one was asked for", "Largest part: approximation"));
  DispatchRecord far{.id = 1, .at = Vec3(0.022, 0, 0)}, late{.id = 2, .at = Vec3(0.003, 0, 0)};
  far.finished = far.known = 1;
  late.requested = 1.5;
  late.finished = late.known = 2.25;
  far.status = late.status = DispatchStatus::solved;
  result.dispatch = {far, late};
  result.frames[0].known = 1;
  CHECK_THAT(bad_moments(result, view)[0].why,
             Catch::StartsWith("The only known state was 20 mm away. A state 1 mm away was asked for "
                               "0.5 s before and came 0.25 s too late."));
  result.dispatch[1].started = 2;
  CHECK_THAT(bad_moments(result, view)[0].why,
             Contains("asked for 0.5 s before, waited 0.5 s for a free worker, took 0.25 s to solve "
                      "and came 0.25 s too late."));
  result.frames[0].judged.staleness = 1;
  result.frames[0].at = Vec3(0.2, 0, 0);
  CHECK_THAT(bad_moments(result, view)[0].why, Contains("outside the box", "Largest part: staleness"));
}

TEST_CASE("the data of the curves hold every frame of a short run, and at most 60,000 of a long one") {
  std::vector<FrameRecord> frames;
  for (int i = 0; i < 130'000; ++i) frames.push_back(frame(1e-3 * i, i % 1000 == 0 ? 0.1 : unknown));
  const auto long_run = json::parse(run_data(result_with(frames), view));
  CHECK(long_run["frames"] == 43'334);
  CHECK(long_run["samples"].size() == 130);
  CHECK(long_run["columns"].get<std::string>().size() == (43'334u * 8 * 4 + 2) / 3 * 4);
  frames.resize(1001);
  const auto run = json::parse(run_data(result_with(frames), view));
  CHECK(run["frames"] == 1001);
  CHECK(run["end"] == Approx(1.0));
  CHECK(run["limit"] == 5.0);
  CHECK(run["clamped"].empty());
  CHECK(run["samples"][1][0] == 1.0);
  CHECK(run["samples"][1][1] == Approx(1.1));
  CHECK(run["columns"].get<std::string>().substr(0, 10) == "AAAAAG8Sgz");  // 0 and 0.001 as floats
}

TEST_CASE(
    "a session's report: bad cards are marked, headlines have their samples, no raw JSON runs out of it") {
  const BeamShop shop("[session.limits]\nforce = 0.02\n");
  shop.run(
      "session beam.toml --clock virtual --seconds 1 --cost constant:0.02 --device "
      "path:press,speed=0.02 -o run --quiet");
  const std::string page = shop.read("run/report.html");
  CHECK_THAT(page, Contains("<div class=\"tile bad\"><b>"));
  CHECK_THAT(page, Contains("of 1000 frames clamped at 0.02 N"));
  CHECK_THAT(page, Contains("load: states that the motion needs"));
  CHECK_THAT(page, Contains("<details><summary>All numbers") && Contains("<details><summary>Notes ("));
  CHECK_THAT(page, !Contains("<td class=\"n\">–</td>") && !Contains(">stability.generated_in.safe<"));
  CHECK_THAT(page, Contains("<h3>prediction.kalman</h3>", "<th>horizon [s]</th>", "<th>p95 [m]</th>"));
  CHECK_THAT(page, !Contains("{&quot;horizon") && !Contains("{\"horizon"));
  for (const char* headline : {"<h2>Force, label and error over time (", "<h2>Around one switch (",
                               "<h2>Where the errors were (", "<h2>Error by label ("})
    CHECK_THAT(page, Contains(headline));
  const std::size_t begin = page.find("id=\"run-data\">") + 14;
  const auto data = json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  CHECK(data["frames"] == 1000);
  CHECK_FALSE(data["clamped"].empty());
  CHECK_FALSE(data["samples"].empty());

  const auto summary = json::parse(shop.read("run/summary.json"));
  const std::size_t samples = summary["error"]["samples"];
  REQUIRE(data["samples"].size() > samples);
  CHECK_THAT(page, Contains(fmt::format("over time ({} samples, {} more at first visits)", samples,
                                        data["samples"].size() - samples)));
  const int ending = summary["loop"]["ending_frames"];
  REQUIRE(ending > 0);
  CHECK_THAT(page, Contains(fmt::format("in the last {} frames it shrinks to zero", ending)));
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
  const BeamShop shop("[session]\nseconds = 0.4\ncost = \"constant:0.01\"\n");
  shop.write("study.toml",
             "scene = \"beam.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n"
             "device = [\"path:circle,speed=0.03\", \"path:line,speed=0.03\"]\nworkers = [1, 2]\n");
  const std::string command = "study study.toml -o out --quiet --figures pdf,svg --palette '#123456,#fedcba'";
  const Workshop::Outcome run = shop.forefeel(command);
  if (!has_command("gnuplot")) {
    CHECK(run.code == 1);
    skip("gnuplot is not installed");
    return;
  }
  INFO(run.err);
  REQUIRE(run.code == 0);
  const std::string page = shop.read("out/report.html");
  const std::size_t verdict = page.find("class=\"verdict"), devices = page.find("<h2>Devices</h2>");
  REQUIRE(verdict != std::string::npos);
  CHECK(verdict < devices);
  CHECK_THAT(page, Contains("of motion and seed)</h2>", "energy given back [mJ]", "clamped [%]"));
  CHECK_THAT(shop.files(), Contains("out/figures/ranking-policy-0.pdf", "out/figures/over-workers.svg"));
  CHECK_THAT(shop.read("out/figures/ranking-policy-0.pdf"), Catch::StartsWith("%PDF"));
  CHECK_THAT(shop.read("out/figures/over-workers.svg"), Contains("18,  52,  86"));
  const auto gantt = shop.run("study study.toml -o out --quiet --gantt 1");
  CHECK_THAT(shop.read("out/cell-0001/gantt.svg"), Contains("half: never used", ">safe<"));
  const std::string summary = shop.read("out/cell-0001/summary.json");
  CHECK(json::parse(summary)["discretisation_error"].get<double>() > 0);  // measured, not "not measured"
  shop.run("study study.toml -o out --quiet --gantt 1 --palette grey --figures pdf");
  CHECK_THAT(shop.read("out/cell-0001/gantt.svg"), Contains("47,  47,  47"));  // grey's safe
  CHECK_THAT(shop.read("out/cell-0001/gantt.pdf"), Catch::StartsWith("%PDF"));
  check_refused(shop, "study study.toml -o new --figures gif", {"--figures", "gif", "svg, png, pdf"});
  check_refused(shop, "study study.toml -o new --palette mine", {"--palette", "okabe-ito"});
}

TEST_CASE("the picture of classify has the same size in SVG and PNG") {
  if (!has_command("gnuplot")) {
    skip("gnuplot is not installed");
    return;
  }
  const Workshop shop;
  shop.write("s_1.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,0,0\n0,0.02,0,0,-1,0\n0,0,0.01,0,0,-1\n");
  shop.run("classify s_1.csv --spacing 0.006 -o c.svg --quiet");
  shop.run("classify s_1.csv --spacing 0.006 -o c.png --quiet");
  const std::string png = shop.read("c.png"), svg = shop.read("c.svg");
  const auto size_at = [&](std::size_t byte) {  // of the header, high byte first
    return static_cast<unsigned char>(png[byte + 2]) * 256 + static_cast<unsigned char>(png[byte + 3]);
  };
  REQUIRE(png.size() > 24);
  CHECK_THAT(svg, Contains("width=\"" + std::to_string(size_at(16)) + "\" height=\"" +
                           std::to_string(size_at(20)) + "\""));
  CHECK_THAT(svg, Contains("Coverage of s_1.csv"));
}

TEST_CASE("the picture of classify has room for long numbers at its axes") {
  const Workshop shop;
  const auto width_of = [&](const std::string& box) {
    shop.run("classify s.csv --spacing 0.006 --box=" + box + " -o c.svg --quiet");
    const std::string svg = shop.read("c.svg");
    CHECK_THAT(svg, Contains("component") && !Contains(" part"));
    return std::stoi(svg.substr(svg.find("width=\"") + 7));
  };
  shop.write("s.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n0.01,0,0,-1,0,0\n0,0.02,0,0,-1,0\n0,0,0.01,0,0,-1\n");
  const int usual = width_of("0,0,0:0.01,0.02,0.01");
  CHECK(width_of("0,-0.0002494,0:0.01,0.02,0.01") == usual + 4 * 8 * 2);  // -0.2494: two letters more
}

TEST_CASE("a session's figures become files; a palette colours them, its report and classify's pictures") {
  if (!has_command("gnuplot")) {
    skip("gnuplot is not installed");
    return;
  }
  const BeamShop shop;
  const std::string session =
      "session beam.toml --clock virtual --seconds 0.5 --device path:circle,speed=0.04 --cost constant:0.02 "
      "--quiet ";
  shop.run(session + "-o usual");
  shop.run(session + "-o run --figures pdf,svg --palette grey");
  CHECK(!fs::exists(shop.path() / "usual/figures"));
  for (const char* name : {"time", "slice"}) {
    CHECK_THAT(shop.read(std::string("run/figures/") + name + ".pdf"), Catch::StartsWith("%PDF"));
    CHECK_THAT(shop.read(std::string("run/figures/") + name + ".svg"), Contains("<svg"));
  }
  CHECK_THAT(shop.read("run/report.html"), Contains("#2f2f2f") && !Contains("#0b4f7d"));
  CHECK_THAT(shop.read("usual/report.html"), Contains("#0b4f7d", "#57a7d6"));
  const std::string classify = "classify run/session.states --quiet -o ";
  shop.run(classify + "c.svg --palette '#010203,#040506,#070809'");
  CHECK_THAT(shop.read("c.svg"), Contains("#010203", "#070809"));
  shop.run(classify + "c.pdf --palette bright");
  CHECK_THAT(shop.read("c.pdf"), Catch::StartsWith("%PDF"));
  check_refused(shop, session + "-o none --palette mine", {"--palette", "okabe-ito"});
  CHECK(!fs::exists(shop.path() / "none"));
}
