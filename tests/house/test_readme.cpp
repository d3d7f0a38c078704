// The commands of README.md work as they are written.

#include <regex>

#include "tests/support/executable.hpp"

namespace {

std::string readme() {
  std::ifstream in(source_folder() / "README.md");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// The first fenced block of a language below a heading.
std::string block(const std::string& heading, const std::string& language) {
  const std::string text = readme(), fence = "```" + language + "\n";
  const std::size_t section = text.find("\n## " + heading + "\n");
  REQUIRE(section != std::string::npos);
  const std::size_t begin = text.find(fence, section);
  REQUIRE(begin < text.find("\n## ", section + 1));
  return text.substr(begin + fence.size(), text.find("\n```", begin) + 1 - begin - fence.size());
}

// The repository as a person sees it, without building it again.
void lay_out(const Workshop& shop) {
  fs::create_directory_symlink(source_folder() / "apps", shop.path() / "apps");
  fs::create_directories(shop.path() / "build/release");
  fs::create_directory_symlink(build_folder() / "apps", shop.path() / "build/release/apps");
}

void check_runs(const Workshop& shop, const std::string& script) {
  shop.write("script.sh", script);
  const Workshop::Outcome outcome = shop.shell("bash -euo pipefail script.sh");
  INFO(script << "\nstdout: " << outcome.out << "\nstderr: " << outcome.err);
  CHECK(outcome.code == 0);
}

// An egg of 160 triangles, in a unit of its own.
std::string organ() {
  std::ostringstream text;
  const int around = 10, rings = 8;
  text << "v 0 0 -3\n";
  for (int i = 1; i < rings + 1; ++i)
    for (int j = 0; j < around; ++j) {
      const double polar = M_PI * i / (rings + 1), turn = 2 * M_PI * j / around;
      text << "v " << 4 * std::sin(polar) * std::cos(turn) << ' ' << 3 * std::sin(polar) * std::sin(turn)
           << ' ' << -3 * std::cos(polar) << '\n';
    }
  text << "v 0 0 3\n";
  const int top = rings * around + 2;
  const auto at = [&](int ring, int j) { return 2 + ring * around + j % around; };
  for (int j = 0; j < around; ++j) {
    text << "f 1 " << at(0, j + 1) << ' ' << at(0, j) << '\n'
         << "f " << top << ' ' << at(rings - 1, j) << ' ' << at(rings - 1, j + 1) << '\n';
    for (int ring = 0; ring + 1 < rings; ++ring)
      text << "f " << at(ring, j) << ' ' << at(ring, j + 1) << ' ' << at(ring + 1, j) << '\n'
           << "f " << at(ring, j + 1) << ' ' << at(ring + 1, j + 1) << ' ' << at(ring + 1, j) << '\n';
  }
  return text.str();
}

}  // namespace

TEST_CASE("the recipes", "[readme]" SLOW("runs the README's commands")) {
  const Workshop shop;
  lay_out(shop);
  check_runs(shop, block("Recipes", "sh"));
  const std::string files = shop.files();
  for (const char* file : {"build/tour/liver.states", "build/tour/coverage.svg", "build/tour/run/report.html",
                           "build/tour/hand/report.html", "build/tour/study/report.html"})
    CHECK_THAT(files, Contains(file));
  // In an example session, the force must not be clamped most of the time.
  for (const std::string run : {"run", "hand"}) {
    CAPTURE(run);
    const auto summary = json::parse(shop.shell("cat build/tour/" + run + "/summary.json").out);
    CHECK(summary["safety"]["clamped_share"] < 0.01);
    CHECK(summary["time_outside"] < 0.05);
    CHECK(summary["error"]["within_jnd"] > 0.5);
  }
  const std::string column =
      "awk -F, 'NR==1{for(i=1;i<=NF;i++)if($i==\"safety.clamped_share\")c=i} NR>1&&$c>=0.01' ";
  CHECK(shop.shell("sed 's/\"[^\"]*\"/text/g' build/tour/study/cells.csv | " + column).out.empty());
}

TEST_CASE("the recipes after an installation", "[readme]" SLOW("installs, and runs the README's commands")) {
  const Workshop shop;
  const auto installed =
      shop.shell("cmake --install '" + build_folder().string() + "' --component forefeel --prefix usr");
  INFO(installed.out << installed.err);
  REQUIRE(installed.code == 0);
  std::string script = block("Recipes", "sh");
  const std::string written = "share=apps ";
  REQUIRE_THAT(script, Contains(written));
  script.replace(script.find(written), written.size(), "share=usr/share/forefeel ");
  CHECK_THAT(script, !Contains(" apps/"));
  check_runs(shop, "export PATH=\"$PWD/usr/bin:$PATH\"\n" + script);
  CHECK_THAT(shop.files(), Contains("build/tour/run/report.html", "build/tour/study/report.html"));
}

TEST_CASE("a mesh of one's own", "[readme]" SLOW("runs the README's commands")) {
  const Workshop shop;
  lay_out(shop);
  shop.write("my-organ.obj", organ());
  check_runs(shop, "export PATH=\"$PWD/build/release/apps:$PATH\"\n" + block("Your own mesh", "sh"));
  CHECK_THAT(shop.files(), Contains("my-run/report.html"));
  const auto summary = json::parse(shop.shell("cat my-run/summary.json").out);
  CHECK(summary["safety"]["clamped_share"] < 0.01);
}

TEST_CASE("states of one's own", "[readme]") {
  const Workshop shop;
  lay_out(shop);
  std::ostringstream forces;
  forces << "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 64; ++i) {
    const double x = 0.005 * (i % 4), y = 0.005 * (i / 4 % 4), z = -0.005 * (i / 16);
    forces << x << ',' << y << ',' << z << ',' << -20 * x << ',' << -20 * y << ',' << -100 * z + 400 * z * z
           << '\n';
  }
  shop.write("my-forces.csv", forces.str());
  shop.write("my-points.csv", "x,y,z\n0.004,0.007,-0.006\n");
  check_runs(shop, "export PATH=\"$PWD/build/release/apps:$PATH\"\n" + block("Your own states", "sh"));
  CHECK_THAT(shop.files(), Contains("my-coverage.svg", "my.states"));
}

TEST_CASE("what the README names exists, and it is short", "[readme]") {
  const std::string text = readme();
  CHECK(std::ranges::count(text, '\n') <= 150);
  const std::regex path(
      R"((?:^|[\s`(])((?:apps|tests|geometry|solver|approx|scheduling)/[A-Za-z0-9_./-]+\.[a-z]+))");
  int found = 0;
  for (std::sregex_iterator match(text.begin(), text.end(), path), end; match != end; ++match, ++found) {
    INFO((*match)[1]);
    CHECK(fs::exists(source_folder() / (*match)[1].str()));
  }
  CHECK(found > 5);
}

TEST_CASE("the command of the README that builds the example builds it, and the example knows its policy",
          "[readme]") {
  std::smatch named;
  const std::string text = readme();
  REQUIRE(std::regex_search(text, named,
                            std::regex("`cmake --build --preset release --target (forefeel_example)`")));
  const Workshop shop;
  const fs::path example = build_folder() / "apps" / named[1].str();
  // The preset names the folder build/release; this build may have another.
  const auto built = shop.shell("cmake --build '" + build_folder().string() + "' --target " + named[1].str());
  INFO(built.out << built.err);
  REQUIRE(built.code == 0);
  shop.write("beam.toml", beam_scene());
  const std::string session =
      " session beam.toml --clock virtual --seconds 0.1 --cost constant:0.01 --policy ahead --quiet -o run";
  CHECK(shop.shell("'" + example.string() + "'" + session).code == 0);
  CHECK(shop.shell(executable() + session).code == 2);  // the plain command does not know it
}
