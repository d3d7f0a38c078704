// The commands and snippets of README.md and of the guide work as they are written.

#include <iterator>
#include <map>
#include <regex>

#include "tests/support/executable.hpp"

namespace {

// README.md and the pages of the guide, with the words of `forefeel help` that print them.
const std::map<std::string, std::string> pages{{"README.md", ""},
                                               {"geometry/README.md", "labels"},
                                               {"solver/README.md", "bodies"},
                                               {"approx/README.md", "models"},
                                               {"scheduling/README.md", "study"},
                                               {"apps/README.md", "report"}};

std::string page_text(const std::string& page) {
  std::ifstream in(source_folder() / page);
  INFO(page);
  REQUIRE(in);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The fenced blocks of a language.
std::vector<std::string> blocks(const std::string& page, const std::string& language) {
  const std::string text = page_text(page), fence = "\n```" + language + "\n";
  std::vector<std::string> found;
  for (std::size_t at = 0; (at = text.find(fence, at)) != std::string::npos;) {
    at += fence.size();
    found.push_back(text.substr(at, text.find("\n```", at) + 1 - at));
  }
  return found;
}

// All commands of a page but those that install, build and say where the command is: that is done before.
std::string commands(const std::string& page) {
  std::string script;
  for (const std::string& block : blocks(page, "sh"))
    if (block.find("apps/setup.sh") == std::string::npos &&
        block.find("quickstart.sh") == std::string::npos && block.find("export PATH") == std::string::npos)
      script += block;
  REQUIRE(!script.empty());
  return script;
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

// What a reader brings: an organ, its scene as the page of bodies has it, points, values and forces.
void bring(const Workshop& shop) {
  shop.write("organ.obj", organ());
  const std::string bodies = page_text("solver/README.md");
  const std::string begin = "cat > organ.toml <<'SCENE'\n";
  const std::size_t at = bodies.find(begin) + begin.size();
  shop.write("organ.toml", bodies.substr(at, bodies.find("SCENE\n", at) - at));
  std::ostringstream points, values, forces;
  values << "x,y,z,temperature\n";
  forces << "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 125; ++i) {
    const double x = 0.005 * (i % 5), y = 0.005 * (i / 5 % 5), z = -0.005 * (i / 25);
    points << x << ',' << y << ',' << z << '\n';
    values << x << ',' << y << ',' << z << ',' << 20 + 100 * x + 5 * z << '\n';
    forces << x << ',' << y << ',' << z << ',' << -20 * x << ',' << -20 * y << ',' << -100 * z + 400 * z * z
           << '\n';
  }
  shop.write("points.csv", points.str());
  shop.write("values.csv", values.str());
  shop.write("forces.csv", forces.str());
  shop.write("states.csv", forces.str());
  shop.write("query.csv", "x,y,z\n0.004,0.007,-0.006\n");
}

void run_page(const Workshop& shop, const std::string& page, const std::string& before = {}) {
  lay_out(shop);
  bring(shop);
  // The pages that press an organ of the reader's own begin where the page of labels has meshed it.
  const std::string mesh = "forefeel mesh organ.obj -o organ.msh --elements 2000 --length 0.2\n";
  check_runs(shop,
             "export PATH=\"$PWD/build/release/apps:$PATH\" share=apps\n" + before + mesh + commands(page));
}

json document(const Workshop& shop, const std::string& file) {
  return json::parse(shop.shell("cat " + file).out);
}

}  // namespace

TEST_CASE("the commands of the page of labels", "[readme]" SLOW("meshes an organ")) {
  const Workshop shop;
  run_page(shop, "geometry/README.md");
  CHECK_THAT(shop.files(), Contains("labels.svg", "grid.csv", "regions.vtu", "values.states", "organ.html"));
}

TEST_CASE("the commands of the page of bodies", "[readme]" SLOW("solves a lattice of the liver")) {
  const Workshop shop;
  run_page(shop, "solver/README.md");
  CHECK_THAT(shop.files(), Contains("liver.states"));
}

TEST_CASE("the commands of the page of models", "[readme]") {
  const Workshop shop;
  lay_out(shop);
  bring(shop);
  check_runs(shop,
             "export PATH=\"$PWD/build/release/apps:$PATH\" share=apps\n" + commands("approx/README.md"));
  CHECK_THAT(shop.files(), Contains("measured.states"));
}

TEST_CASE("the commands of the page of sessions and studies", "[readme]" SLOW("runs a study")) {
  const Workshop shop;
  run_page(shop, "scheduling/README.md");
  CHECK_THAT(shop.files(),
             Contains("study/report.html", "mine/report.html", "run/report.html", "anywhere/report.html"));
  // In an example session, the force must not be clamped most of the time.
  const json summary = document(shop, "run/summary.json");
  CHECK(summary["safety"]["clamped_share"] < 0.01);
  CHECK(summary["error"]["within_jnd"] > 0.5);
  const std::string column =
      "awk -F, 'NR==1{for(i=1;i<=NF;i++)if($i==\"safety.clamped_share\")c=i} NR>1&&$c>=0.01' ";
  CHECK(shop.shell("sed 's/\"[^\"]*\"/text/g' study/cells.csv | " + column).out.empty());
}

TEST_CASE("the commands of the page of reports", "[readme]" SLOW("repeats figures of the paper")) {
  const Workshop shop;
  run_page(shop, "apps/README.md");
  CHECK_THAT(shop.files(), Contains("run/show.html", "run.pvd", "merged/report.html"));
}

TEST_CASE("the commands of README.md after an installation",
          "[readme]" SLOW("installs, and runs the README's commands")) {
  const Workshop shop;
  const auto installed =
      shop.shell("cmake --install '" + build_folder().string() + "' --component forefeel --prefix usr");
  INFO(installed.out << installed.err);
  REQUIRE(installed.code == 0);
  bring(shop);
  check_runs(shop, "export PATH=\"$PWD/usr/bin:$PATH\" share=usr/share/forefeel\n" + commands("README.md"));
  CHECK_THAT(shop.files(), Contains("study/report.html", "labels.svg", "organ-run/report.html"));
  CHECK(document(shop, "organ-run/summary.json")["safety"]["clamped_share"] < 0.01);
}

TEST_CASE("the Python of the pages runs as it is written", "[readme]" SLOW("runs sessions in Python")) {
  if (!fs::exists(build_folder() / "apps/python/forefeel")) return skip("no Python module");
  const Workshop shop;
  lay_out(shop);
  bring(shop);
  REQUIRE(shop.shell(executable() + " mesh organ.obj -o organ.msh --elements 2000 --length 0.2").code == 0);
  int found = 0;
  for (const auto& [page, topic] : pages)
    for (const std::string& block : blocks(page, "python")) {
      shop.write("snippet.py", block);
      const auto ran = shop.shell(
          "PYTHONPATH=build/release/apps/python /usr/bin/python3 -W error::UserWarning snippet.py");
      INFO(page << "\n" << block << "\n" << ran.out << ran.err);
      CHECK(ran.code == 0);
      CHECK(!ran.out.empty());
      ++found;
    }
  CHECK(found >= 5);
}

TEST_CASE("pages are short, begin with a command or a picture, and `forefeel help` prints them", "[readme]") {
  const Workshop shop;
  for (const auto& [page, topic] : pages) {
    CAPTURE(page);
    const std::string text = page_text(page);
    std::istringstream words(text);
    const auto count = std::distance(std::istream_iterator<std::string>(words), {});
    CHECK(count <= (topic.empty() ? 900 : 800));
    const std::size_t first = text.find("\n\n") + 2;
    CHECK(text.compare(first, 5, topic.empty() ? "![A h" : "```sh") == 0);
    if (topic.empty()) continue;
    const std::string told = shop.shell(executable() + " help " + topic).out;
    CHECK(told.compare(0, text.size(), text) == 0);
    CHECK_THAT(page_text("README.md"), Contains("(" + page + ")", "`forefeel help " + topic + "`"));
  }
}

TEST_CASE("what the pages name exists", "[readme]") {
  const std::regex path(
      R"((?:^|[\s`(])((?:apps|tests|geometry|solver|approx|scheduling)/[A-Za-z0-9_./-]+\.[a-z]+))");
  const std::regex link(R"(\]\(([^)]+)\))");
  int found = 0;
  for (const auto& [page, topic] : pages) {
    const std::string text = page_text(page);
    for (std::sregex_iterator match(text.begin(), text.end(), path), end; match != end; ++match, ++found) {
      INFO(page << ": " << (*match)[1]);
      CHECK(fs::exists(source_folder() / (*match)[1].str()));
    }
    for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match, ++found) {
      INFO(page << ": " << (*match)[1]);
      CHECK(fs::exists((source_folder() / page).parent_path() / (*match)[1].str()));
    }
  }
  CHECK(found > 30);
}

TEST_CASE("one version: that of the project in changelog, citation and command", "[readme]") {
  const std::string project = page_text("CMakeLists.txt");
  std::smatch version;
  REQUIRE(std::regex_search(project, version, std::regex(R"(project\(forefeel VERSION ([0-9.]+) )")));
  CHECK(page_text("apps/package/changelog").starts_with("forefeel (" + version[1].str() + ") "));
  CHECK_THAT(page_text("README.md"), Contains("version = {" + version[1].str() + "}"));
  const Workshop shop;
  CHECK_THAT(shop.shell(executable() + " --version").out, Contains(version[1].str()));
  CHECK(json::parse(page_text(".zenodo.json"))["upload_type"] == "software");
}

TEST_CASE("the target that builds the example builds it, and the example knows its policy", "[readme]") {
  const Workshop shop;
  const fs::path example = build_folder() / "apps/forefeel_example";
  const auto built = shop.shell("cmake --build '" + build_folder().string() + "' --target forefeel_example");
  INFO(built.out << built.err);
  REQUIRE(built.code == 0);
  shop.write("beam.toml", beam_scene());
  const std::string session =
      " session beam.toml --clock virtual --seconds 0.1 --cost constant:0.01 --policy ahead --quiet -o run";
  CHECK(shop.shell("'" + example.string() + "'" + session).code == 0);
  CHECK(shop.shell(executable() + session).code == 2);  // the plain command does not know it
}
