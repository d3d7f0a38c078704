// The command `forefeel study`: table, report and document, and what is left after an interruption or a kill.

#include <iomanip>

#include "tests/support/executable.hpp"

TEST_CASE(
    "forefeel study: table, report and document; a second run has nothing to do; a changed study is said") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.3\ndevice = \"path:press,speed=0.05\"\n"));
  const std::string text =
      "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n";
  shop.write("study.toml", text);
  const auto first = shop.run("study study.toml -o out --json --threads 2");
  const auto document = first.json();
  CHECK(document["cells"] == 4);
  CHECK(document["ran"] == 4);
  CHECK(document["left"] == 0);
  CHECK(document["interrupted"] == false);
  CHECK(document["student_of_means"] == "on the logit scale");
  CHECK(document["rankings"][0]["axis"] == "policy");
  CHECK(document["provenance"].contains("commit"));
  const std::string table = shop.read("out/cells.csv");
  CHECK(std::ranges::count(table, '\n') == 5);
  CHECK_THAT(shop.read("out/report.html"), Contains("logit scale", "Brown, Cai, DasGupta"));
  CHECK(shop.json("study study.toml -o out")["ran"] == 0);
  CHECK(shop.read("out/cells.csv") == table);

  shop.write("study.toml", text + "workers = [2, 3]\n");
  const auto changed = shop.run("study study.toml -o out --json");
  CHECK_THAT(changed.err, Contains("begun with another text of this study"));

  const auto gantt = shop.forefeel("study study.toml -o out --gantt 3 --json");
  CHECK(fs::exists(shop.path() / "out/cell-0003/dispatch.csv"));
  CHECK(gantt.code == (fs::exists(shop.path() / "out/cell-0003/gantt.svg") ? 0 : 1));
  CHECK(shop.forefeel("study study.toml -o out --gantt 9").code == 2);
}

TEST_CASE("forefeel study: the terminal shows the intervals of the document, and none below four motions") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.8\nrest_first = false\nfirst_guess = false\n"));
  const std::string varied =
      "baseline = \"constant:0.02\"\n[vary]\ncost = [\"constant:0.02\", \"constant:0.3\"]\n";
  shop.write("four.toml",
             "scene = \"scene.toml\"\nseeds = [1]\n" + varied +
                 "device = [\"path:circle,speed=0.03\", \"path:reach,speed=0.03\", \"path:line,speed=0.02\", "
                 "\"path:press,speed=0.02\"]\n");
  shop.write("one.toml",
             "scene = \"scene.toml\"\nseeds = [1]\n" + varied + "device = [\"path:circle,speed=0.03\"]\n");
  const auto told = shop.run("study four.toml -o four --json");
  const auto contrast = told.json()["contrasts"][0];
  const auto said = shop.run("study four.toml -o four");
  INFO(said.out << contrast.dump());
  CHECK(contrast["metric"] == "error.first_visit.within_jnd");
  CHECK(contrast["traces"] == 4);
  const auto row = told.json()["rankings"][0]["ranked"][1];
  CHECK(row["p_holm"] == row["to_best"]["p"]);  // of two values there is one comparison
  CHECK(row["mean_rank"].get<double>() >= 1);
  CHECK(told.json()["contrasts"].dump().find("error.first_visit.p95_N") != std::string::npos);
  CHECK_THAT(shop.read("four/report.html"), Contains("p, Holm", "error p95 [mN]"));
  CHECK(contrast["student"][0].get<double>() < contrast["student"][1].get<double>());
  const auto points = [](const json& value) {
    std::ostringstream text;
    text << std::setprecision(3) << 100 * value.get<double>();
    return text.str();
  };
  const auto interval = [&](const char* kind) {
    return "[" + points(contrast[kind][0]) + ", " + points(contrast[kind][1]) + "]";
  };
  CHECK_THAT(said.out,
             Contains("constant:0.3 against constant:0.02: " + points(contrast["mean"]) + ", bootstrap " +
                      interval("bootstrap") + ", Student's " + interval("student")));
  const auto single = shop.run("study one.toml -o one");
  CHECK_THAT(single.out, Contains("1 motion is too few to compare"));
  CHECK_THAT(single.out, Contains("bootstrap none, Student's none: not significant"));
}

TEST_CASE("parts of a study, run apart and merged, have the table of the whole") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.3\ndevice = \"path:press,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"coverage\"]\n");
  shop.run("study study.toml -o whole --quiet");
  for (const std::string part : {"1", "2", "3"}) {
    const auto ran = shop.run("study study.toml -o part-" + part + " --part " + part + "/3 --json");
    CHECK(ran.json()["ran"] == (part == "1" ? 2 : 1));
    CHECK(ran.json()["left"] == 0);
    CHECK(ran.json()["of_other_parts"] == (part == "1" ? 2 : 3));
    CHECK(ran.json()["files"].empty());
    CHECK_FALSE(fs::exists(shop.path() / ("part-" + part) / "cells.csv"));
  }
  const auto merged = shop.run("study --merge part-1 part-2 part-3 -o all --json");
  CHECK(merged.json()["ran"] == 0);
  CHECK(merged.json()["resumed"] == 4);
  CHECK(shop.same("whole/cells.csv", "all/cells.csv"));

  // A merge compares and runs nothing; the study itself then runs what is missing.
  const auto missing = shop.forefeel("study --merge part-1 part-3 -o some --json");
  CHECK(missing.code == 1);
  CHECK(missing.json()["left"] == 1);
  CHECK_THAT(missing.err, Contains("1 of 4 cells are in none of these folders"));
  CHECK(shop.json("study study.toml -o some")["ran"] == 1);
  CHECK(shop.same("whole/cells.csv", "some/cells.csv"));

  check_refused(shop, "study study.toml -o other --merge nowhere",
                {"--merge nowhere", "no cell of this study"});
  check_refused(shop, "study --merge nowhere -o other", {"--merge nowhere", "no sound study.json"});
  check_refused(shop, "study --merge part-1 -o other --set material.young=1.0", {"--set", "no effect"});
  check_refused(shop, "study study.toml -o other --part 1/2 --gantt 1", {"--part", "--gantt"});
  check_refused(shop, "study -o other", {"no study given"});
  for (const std::string wrong : {"0/3", "4/3", "1", "1/", "a/b", "1/3x", "-1/3"})
    check_refused(shop, "study study.toml -o other --part " + wrong, {"--part", "'" + wrong + "'", "K/N"});
}

TEST_CASE("a cell repeated gives the same bytes, whatever is varied, alone or in parts") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.3\nplacement = \"lattice\"\n"));
  fs::create_directories(shop.path() / "hands");
  for (const double speed : {0.02, 0.05}) {
    std::ostringstream rows;
    rows << "t,x,y,z\n";
    for (int k = 0; k <= 30; ++k)
      rows << 0.01 * k << ',' << speed * 0.01 * k << ',' << 1e-5 * k * k << ",0\n";
    shop.write(speed < 0.03 ? "hands/slow.csv" : "hands/fast.csv", rows.str());
  }
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2]\n[session]\ncost = \"lognormal:0.02,0.5\"\n[vary]\n"
             "policy = [\"random\", \"utility\", \"slack\", \"coverage-regions\"]\n"
             "\"session.predictor\" = [\"minimum-jerk\", \"autoregressive\", \"past\"]\n"
             "\"state_space.design\" = [\"halton\", \"farthest\"]\n"
             "device = [\"trace:hands/*.csv\"]\n");
  shop.run("study study.toml -o one --quiet --threads 1");
  shop.run("study study.toml -o two --quiet --threads 3");
  CHECK(shop.same("one/cells.csv", "two/cells.csv"));
  const std::string table = shop.read("one/cells.csv");
  CHECK(std::ranges::count(table, '\n') == 97);
  CHECK_THAT(table, Contains("\nrandom,minimum-jerk,halton,fast,1,"));
  std::set<fs::path> cells;
  for (const auto& entry : fs::directory_iterator(shop.path() / "one/cells")) {
    if (entry.path().extension() != ".json") continue;
    cells.insert(entry.path().filename());
    const std::string name = entry.path().filename().string();
    CHECK(shop.same("one/cells/" + name, "two/cells/" + name));
  }
  CHECK(cells.size() == 96);
  for (const std::string part : {"1", "2"})
    shop.run("study study.toml -o part-" + part + " --quiet --threads 2 --part " + part + "/2");
  shop.run("study --merge part-2 part-1 -o all --quiet");
  CHECK(shop.same("one/cells.csv", "all/cells.csv"));
}

TEST_CASE(
    "parts of a study with --set are merged as they were run; what is damaged is not taken for a cell") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.2\ndevice = \"path:press,speed=0.05\"\n"));
  shop.write("study.toml", "scene = \"scene.toml\"\nseeds = [1, 2]\n[vary]\npolicy = [\"nearest\"]\n");
  const std::string set = " --quiet --set material.young=4000.0";
  shop.run("study study.toml -o whole" + set);
  shop.run("study study.toml -o one --part 1/2" + set);
  shop.run("study study.toml -o two --part 2/2" + set);
  shop.run("study --merge one two -o all");
  CHECK(shop.same("whole/cells.csv", "all/cells.csv"));
  shop.run("study --merge all -o again");  // the manifest of a merge names --set

  REQUIRE(shop.shell("for f in one/cells/*.json; do echo '{\"key\": 5, \"columns\": {}}' > $f; done").code ==
          0);
  check_refused(shop, "study --merge one -o other", {"--merge one", "no cell of this study"});
  for (const std::string damaged : {"{\"cells\": 5}", "{\"file\": 1, \"set\": [1]}", "[", "{}"}) {
    shop.write("two/study.json", damaged);
    check_refused(shop, "study --merge two -o other", {"--merge two", "no sound study.json"});
    shop.run("study study.toml -o two --part 2/2" + set);
  }
}

TEST_CASE("forefeel study: bad input is one line, exit 2, nothing written") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene());
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
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 1.0\ndevice = \"path:circle,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2, 3, 4]\n[vary]\npolicy = [\"nearest\", \"coverage\", "
             "\"fifo\"]\n");
  const auto cut_at = [&](int cells, const std::string& option) {
    return shop.shell(
        "mkdir -p out; " + executable() + " study study.toml -o out --threads 1 " + option + " & p=$!; " +
        wait_until("[ $(ls out/cells 2>/dev/null | grep -c json) -ge " + std::to_string(cells) + " ]") +
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
  CHECK_THAT(cut.err, Contains("interrupted after " + std::to_string(first) + " of 12 cells, " +
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
  const auto resumed = shop.run("study study.toml -o out --json");
  CHECK(resumed.json()["resumed"] == count);
  shop.run("study study.toml -o whole --quiet --threads 1");
  CHECK(shop.same("out/cells.csv", "whole/cells.csv"));
}

TEST_CASE("a study that was killed goes on: no cell is run twice, and the table is the same") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 1.0\ndevice = \"path:circle,speed=0.05\"\n"));
  shop.write("study.toml",
             "scene = \"scene.toml\"\nseeds = [1, 2, 3, 4]\n[vary]\npolicy = [\"nearest\", \"coverage\", "
             "\"fifo\"]\n");
  shop.shell("mkdir out && (" + executable() + " study study.toml -o out --quiet --threads 1 & p=$!; " +
             wait_until("[ $(ls out/cells 2>/dev/null | grep -c json) -ge 2 ]") + "kill -9 $p; wait $p)");
  const auto count = std::stoul(shop.shell("ls out/cells | grep -c '^[0-9a-f]*[.]json$'").out);
  CHECK(count >= 2);
  const auto resumed = shop.run("study study.toml -o out --json");
  CHECK(resumed.json()["resumed"] == count);
  shop.run("study study.toml -o whole --quiet --threads 1");
  CHECK(shop.same("out/cells.csv", "whole/cells.csv"));
}
