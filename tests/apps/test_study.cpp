// The command `forefeel study`: table, report and document, and what is left after an interruption or a kill.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <iomanip>
#include <sstream>

#include "tests/support/executable.hpp"
#include "tests/support/paths.hpp"

using namespace forefeel;
namespace fs = std::filesystem;

TEST_CASE(
    "forefeel study: table, report and document; a second run has nothing to do; a changed study is said") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 0.3\ndevice = \"path:press,speed=0.05\"\n"));
  const std::string text =
      "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n";
  shop.write("study.toml", text);
  const auto first = shop.forefeel("study study.toml -o out --json --threads 2");
  REQUIRE(first.code == 0);
  const auto document = first.json();
  CHECK(document["cells"] == 4);
  CHECK(document["ran"] == 4);
  CHECK(document["left"] == 0);
  CHECK(document["interrupted"] == false);
  CHECK(document["student_of_means"] == "on the logit scale");
  CHECK(document["rankings"][0]["axis"] == "policy");
  CHECK(document["provenance"].contains("commit"));
  const auto table = shop.shell("cat out/cells.csv");
  CHECK(std::ranges::count(table.out, '\n') == 5);
  CHECK_THAT(shop.shell("cat out/report.html").out,
             Catch::Contains("logit scale") && Catch::Contains("Brown, Cai, DasGupta"));
  CHECK(shop.forefeel("study study.toml -o out --json").json()["ran"] == 0);
  CHECK(shop.shell("cat out/cells.csv").out == table.out);

  shop.write("study.toml", text + "workers = [2, 3]\n");
  const auto changed = shop.forefeel("study study.toml -o out --json");
  CHECK(changed.code == 0);
  CHECK(changed.err.find("begun with another text of this study") != std::string::npos);

  const auto gantt = shop.forefeel("study study.toml -o out --gantt 3 --json");
  CHECK(fs::exists(shop.path() / "out/cell-0003/dispatch.csv"));
  CHECK(gantt.code == (fs::exists(shop.path() / "out/cell-0003/gantt.svg") ? 0 : 1));
  CHECK(shop.forefeel("study study.toml -o out --gantt 9").code == 2);
}

TEST_CASE(
    "forefeel study: the terminal shows the intervals of the document, and none where one pair gives none") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 0.8\nrest_first = false\nfirst_guess = false\n"));
  const std::string varied =
      "baseline = \"constant:0.02\"\n[vary]\ncost = [\"constant:0.02\", \"constant:0.3\"]\n";
  shop.write(
      "three.toml",
      "scene = \"scene.toml\"\nseeds = [1]\n" + varied +
          "device = [\"path:circle,speed=0.03\", \"path:reach,speed=0.03\", \"path:line,speed=0.02\"]\n");
  shop.write("one.toml",
             "scene = \"scene.toml\"\nseeds = [1]\n" + varied + "device = [\"path:circle,speed=0.03\"]\n");
  const auto told = shop.forefeel("study three.toml -o three --json");
  REQUIRE(told.code == 0);
  const auto contrast = told.json()["contrasts"][0];
  const auto said = shop.forefeel("study three.toml -o three");
  REQUIRE(said.code == 0);
  INFO(said.out << contrast.dump());
  CHECK(contrast["metric"] == "error.first_visit.within_jnd");
  CHECK(contrast["traces"] == 3);
  CHECK(contrast["student"][0].get<double>() < contrast["student"][1].get<double>());
  const auto points = [](const nlohmann::json& value) {
    std::ostringstream text;
    text << std::setprecision(3) << 100 * value.get<double>();
    return text.str();
  };
  const auto interval = [&](const char* kind) {
    return "[" + points(contrast[kind][0]) + ", " + points(contrast[kind][1]) + "]";
  };
  CHECK_THAT(said.out,
             Catch::Contains("constant:0.3 against constant:0.02: " + points(contrast["mean"]) +
                             ", bootstrap " + interval("bootstrap") + ", Student's " + interval("student")));
  const auto single = shop.forefeel("study one.toml -o one");
  REQUIRE(single.code == 0);
  CHECK_THAT(single.out, Catch::Contains("bootstrap none, Student's none: not significant"));
}

TEST_CASE("parts of a study, run apart and merged, have the table of the whole") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 0.3\ndevice = \"path:press,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n");
  REQUIRE(shop.forefeel("study study.toml -o whole --quiet").code == 0);
  for (const std::string part : {"1", "2", "3"}) {
    const auto ran = shop.forefeel("study study.toml -o part-" + part + " --part " + part + "/3 --json");
    REQUIRE(ran.code == 0);
    CHECK(ran.json()["ran"] == (part == "1" ? 2 : 1));
    CHECK(ran.json()["left"] == 0);
    CHECK(ran.json()["of_other_parts"] == (part == "1" ? 2 : 3));
    CHECK(ran.json()["files"].empty());
    CHECK_FALSE(fs::exists(shop.path() / ("part-" + part) / "cells.csv"));
  }
  const auto merged = shop.forefeel("study --merge part-1 part-2 part-3 -o all --json");
  REQUIRE(merged.code == 0);
  CHECK(merged.json()["ran"] == 0);
  CHECK(merged.json()["resumed"] == 4);
  CHECK(shop.shell("cmp whole/cells.csv all/cells.csv").code == 0);

  // A merge compares and runs nothing; the study itself then runs what is missing.
  const auto missing = shop.forefeel("study --merge part-1 part-3 -o some --json");
  CHECK(missing.code == 1);
  CHECK(missing.json()["left"] == 1);
  CHECK_THAT(missing.err, Catch::Contains("1 of 4 cells are in none of these folders"));
  CHECK(shop.forefeel("study study.toml -o some --json").json()["ran"] == 1);
  CHECK(shop.shell("cmp whole/cells.csv some/cells.csv").code == 0);

  test::check_refused(shop, "study study.toml -o other --merge nowhere",
                      {"--merge nowhere", "no cell of this study"});
  test::check_refused(shop, "study --merge nowhere -o other", {"--merge nowhere", "no sound study.json"});
  test::check_refused(shop, "study --merge part-1 -o other --set material.young=1.0", {"--set", "no effect"});
  test::check_refused(shop, "study study.toml -o other --part 1/2 --gantt 1", {"--part", "--gantt"});
  test::check_refused(shop, "study -o other", {"no study given"});
  for (const std::string wrong : {"0/3", "4/3", "1", "1/", "a/b", "1/3x", "-1/3"})
    test::check_refused(shop, "study study.toml -o other --part " + wrong,
                        {"--part", "'" + wrong + "'", "K/N"});
}

TEST_CASE(
    "parts of a study with --set are merged as they were run; what is damaged is not taken for a cell") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 0.2\ndevice = \"path:press,speed=0.05\"\n"));
  shop.write("study.toml", "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\"]\n");
  const std::string set = " --quiet --set material.young=4000.0";
  REQUIRE(shop.forefeel("study study.toml -o whole" + set).code == 0);
  REQUIRE(shop.forefeel("study study.toml -o one --part 1/2" + set).code == 0);
  REQUIRE(shop.forefeel("study study.toml -o two --part 2/2" + set).code == 0);
  REQUIRE(shop.forefeel("study --merge one two -o all").code == 0);
  CHECK(shop.shell("cmp whole/cells.csv all/cells.csv").code == 0);
  CHECK(shop.forefeel("study --merge all -o again").code == 0);  // the manifest of a merge names --set

  REQUIRE(shop.shell("for f in one/cells/*.json; do echo '{\"key\": 5, \"columns\": {}}' > $f; done").code ==
          0);
  test::check_refused(shop, "study --merge one -o other", {"--merge one", "no cell of this study"});
  for (const std::string damaged : {"{\"cells\": 5}", "{\"file\": 1, \"set\": [1]}", "[", "{}"}) {
    shop.write("two/study.json", damaged);
    test::check_refused(shop, "study --merge two -o other", {"--merge two", "no sound study.json"});
    CHECK(shop.forefeel("study study.toml -o two --part 2/2" + set).code == 0);
  }
}

TEST_CASE("forefeel study: bad input is one line, exit 2, nothing written") {
  const test::Workshop shop;
  shop.write("scene.toml", test::beam_scene());
  shop.write("study.toml", "scene = \"scene.toml\"\nseeds = [1]\n[vary]\npolicy = [\"nearst\"]\n");
  const std::string before = shop.files();
  for (const std::string arguments :
       {"study study.toml -o out", "study none.toml -o out", "study study.toml -o out --seed 3"}) {
    const auto refused = shop.forefeel(arguments);
    CHECK(refused.code == 2);
    CHECK(refused.error_lines() == 1);
    CHECK(shop.files() == before);
  }
}

TEST_CASE("a study that is interrupted keeps what is done, says so, and goes on to the same table") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 1.0\ndevice = \"path:circle,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2, 3, 4]\n[vary]\npolicy = [\"nearest\", \"coverage\", "
             "\"fifo\"]\n");
  const auto cut_at = [&](int cells, const std::string& option) {
    return shop.shell(
        "mkdir -p out; " + test::executable() + " study study.toml -o out --threads 1 " + option +
        " & p=$!; " +
        test::wait_until("[ $(ls out/cells 2>/dev/null | grep -c json) -ge " + std::to_string(cells) + " ]") +
        "kill -INT $p; wait $p");
  };
  const auto done = [&] { return std::stoul(shop.shell("ls out/cells | grep -c '^[0-9a-f]*[.]json$'").out); };
  const auto cut = cut_at(2, "--quiet");
  CHECK(cut.code == 1);
  CHECK(cut.out.empty());
  CHECK(cut.error_lines() == 1);
  const auto first = done();
  CHECK(first >= 2);
  CHECK(first < 12);
  CHECK_THAT(cut.err, Catch::Contains("interrupted after " + std::to_string(first) + " of 12 cells, " +
                                      std::to_string(12 - first) + " left"));
  const auto told = cut_at(static_cast<int>(first) + 2, "--json");
  CHECK(told.code == 1);
  const auto count = done();
  CHECK(told.json()["interrupted"] == true);
  CHECK(told.json()["cells"] == 12);
  CHECK(told.json()["resumed"] == first);
  CHECK(told.json()["ran"] == count - first);
  CHECK(told.json()["left"] == 12 - count);
  CHECK(told.json()["provenance"].contains("commit"));
  CHECK_FALSE(fs::exists(shop.path() / "out/cells.csv"));
  const auto resumed = shop.forefeel("study study.toml -o out --json");
  REQUIRE(resumed.code == 0);
  CHECK(resumed.json()["resumed"] == count);
  REQUIRE(shop.forefeel("study study.toml -o whole --quiet --threads 1").code == 0);
  CHECK(shop.shell("cmp out/cells.csv whole/cells.csv").code == 0);
}

TEST_CASE("a study that was killed goes on: no cell is run twice, and the table is the same") {
  const test::Workshop shop;
  shop.write("scene.toml",
             test::beam_scene("[session]\nseconds = 1.0\ndevice = \"path:circle,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2, 3, 4]\n[vary]\npolicy = [\"nearest\", \"coverage\", "
             "\"fifo\"]\n");
  shop.shell("mkdir out && (" + test::executable() + " study study.toml -o out --quiet --threads 1 & p=$!; " +
             test::wait_until("[ $(ls out/cells 2>/dev/null | grep -c json) -ge 2 ]") +
             "kill -9 $p; wait $p)");
  const auto count = std::stoul(shop.shell("ls out/cells | grep -c '^[0-9a-f]*[.]json$'").out);
  CHECK(count >= 2);
  const auto resumed = shop.forefeel("study study.toml -o out --json");
  REQUIRE(resumed.code == 0);
  CHECK(resumed.json()["resumed"] == count);
  REQUIRE(shop.forefeel("study study.toml -o whole --quiet --threads 1").code == 0);
  CHECK(shop.shell("cmp out/cells.csv whole/cells.csv").code == 0);
}
