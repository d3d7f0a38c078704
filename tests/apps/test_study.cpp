// Studies: what a file means, every contradiction refused in one line, cells that repeat whatever the threads
// and however often the work is broken off.

#include "apps/study/study.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <set>
#include <sstream>

#include "apps/picture/study_report.hpp"
#include "apps/study/study_plan.hpp"
#include "apps/study/study_ranking.hpp"
#include "apps/study/study_run.hpp"
#include "apps/study/study_speed.hpp"
#include "apps/study/study_table.hpp"
#include "tests/support/executable.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace forefeel;
namespace fs = std::filesystem;

namespace {

// With a small linear body: its state space costs three solves.
struct Folder {
  test::TemporaryFolder folder;
  fs::path path = folder.path();

  Folder() {
    write("scene.toml",
          "[body]\nphantom = \"slab\"\nelements = 150\n[material]\nlaw = \"linear\"\nyoung = 5000.0\npoisson "
          "= 0.3\n"
          "[state_space]\nspacing = 0.006\nbox = [[-0.018, -0.018, -0.018], [0.018, 0.018, 0.018]]\n"
          "[session]\ndevice = \"path:press,speed=0.06\"\nseconds = 0.4\n");
  }
  fs::path write(const std::string& name, const std::string& text) const { return folder.write(name, text); }
  fs::path study(const std::string& text) const {
    return write("study.toml", "scene = \"scene.toml\"\n" + text);
  }
};

std::string refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::vector<CellColumns> run(const StudyPlan& plan, const fs::path& folder, int threads,
                             std::size_t* ran = nullptr) {
  Globals globals;
  globals.quiet = true;
  globals.threads = threads;
  StudyResult result = run_study(plan, folder, globals);
  if (ran) *ran = result.ran;
  add_regret(plan.study, result.cells);
  return result.cells;
}

// Cells whose value for each metric is a formula, for the ranking: no session needed.
std::vector<CellColumns> made_up(
    const Study& study, const std::function<double(const std::vector<std::size_t>&, std::uint64_t)>& f) {
  std::vector<CellColumns> cells;
  for (std::size_t c = 0; c < study.combinations(); ++c)
    for (const std::uint64_t seed : study.seeds) {
      CellColumns cell = CellColumns::object();
      cell["error.first_visit.within_jnd"] = f(study.choice(c), seed);
      cell["error.within_jnd"] = 0.5;
      cell["error.first_visit.p95"] = std::exp(-f(study.choice(c), seed));
      cells.push_back(cell);
    }
  return cells;
}

}  // namespace

TEST_CASE("a study: axes in the order of the file, the first slowest, the seed fastest") {
  const Folder folder;
  const Study study = read_study(
      folder.study("seeds = [4, 2]\n[session]\nseconds = 0.5\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n"
                   "\"model.neighbours\" = [8, 12, 16]\nselect = [\"nearest\"]\n"),
      {});
  REQUIRE(study.axes.size() == 3);
  CHECK(study.axes[0].column == "policy");
  CHECK(study.axes[1].column == "model.neighbours");
  CHECK(study.combinations() == 6);
  CHECK(study.cells() == 12);
  CHECK(study.choice(0) == std::vector<std::size_t>{0, 0, 0});
  CHECK(study.choice(1) == std::vector<std::size_t>{0, 1, 0});
  CHECK(study.choice(5) == std::vector<std::size_t>{1, 2, 0});
  const std::vector<std::string> overrides = study.overrides(study.choice(4));
  const std::set<std::string> given(overrides.begin(), overrides.end());
  CHECK(given == std::set<std::string>{"session.seconds=0.5", "session.policy=\"fifo\"",
                                       "model.neighbours=12", "session.select=\"nearest\""});
}

TEST_CASE("keys of one section may change together, under a name") {
  const Folder folder;
  const Study study =
      read_study(folder.study("seeds = [1]\n[vary]\nmodel = [{ name = \"old\", kernel = \"cubic\", "
                              "neighbours = 100 }, { kernel = \"quintic\", select = \"nearest\" }]\n"),
                 {});
  REQUIRE(study.axes.size() == 1);
  CHECK(study.axes[0].values[0].text == "old");
  CHECK(study.axes[0].values[0].overrides ==
        std::vector<std::string>{"model.kernel=\"cubic\"", "model.neighbours=100"});
  CHECK(study.axes[0].values[1].overrides ==
        std::vector<std::string>{"model.kernel=\"quintic\"", "session.select=\"nearest\""});
}

TEST_CASE("steps keep what the former ones changed") {
  const Folder folder;
  const Study study = read_study(
      folder.study("seeds = [1]\n[[step]]\nname = \"old\"\npolicy = \"nearest\"\nswitch = \"paper\"\n"
                   "[[step]]\nname = \"smooth\"\nswitch = \"smooth\"\n[[step]]\nname = \"ours\"\npolicy = "
                   "\"coverage\"\n"
                   "\"model.kernel\" = \"cubic\"\n"),
      {});
  REQUIRE(study.axes.size() == 1);
  CHECK(study.axes[0].values[0].overrides ==
        std::vector<std::string>{"session.policy=\"nearest\"", "session.switch=\"paper\""});
  CHECK(study.axes[0].values[1].overrides ==
        std::vector<std::string>{"session.policy=\"nearest\"", "session.switch=\"smooth\""});
  CHECK(study.axes[0].values[2].overrides == std::vector<std::string>{"model.kernel=\"cubic\"",
                                                                      "session.policy=\"coverage\"",
                                                                      "session.switch=\"smooth\""});
}

namespace {

struct Bad {
  std::string text;
  std::vector<std::string> said;
};

// In one line, with every word.
void check_refused(const Folder& folder, const Bad& bad) {
  const std::string said = refusal([&] { plan_study(read_study(folder.study(bad.text), {})); });
  INFO(bad.text << "said: " << said);
  CHECK_FALSE(said.empty());
  CHECK(said.find('\n') == std::string::npos);
  for (const std::string& word : bad.said) CHECK(said.find(word) != std::string::npos);
}

}  // namespace

TEST_CASE("whatever contradicts itself or cannot run is one line that names the place") {
  const Folder folder;
  const std::vector<Bad> all{
      {"seeds = [1, 2, 1]\n", {"study.toml:2: seeds", "1 twice"}},
      {"seeds = []\n", {"study.toml:2: seeds", "empty"}},
      {"", {"seeds", "missing"}},
      {"seeds = [1.5]\n", {"seeds", "whole numbers"}},
      {"seeds = [-1]\n", {"seeds", "at least 0"}},
      {"seeds = [1]\nvarry = 3\n", {"study.toml:3: varry", "did you mean 'vary'"}},
      {"seeds = [1]\n[vary]\n", {"vary", "empty"}},
      {"seeds = [1]\n[vary]\npolicy = []\n", {"study.toml:4: vary.policy", "empty list"}},
      {"seeds = [1]\n[vary]\npolicy = \"fifo\"\n", {"study.toml:4: vary.policy", "expected a list"}},
      {"seeds = [1]\n[vary]\npolcy = [\"fifo\"]\n", {"study.toml:4: vary.polcy", "did you mean 'policy'"}},
      {"seeds = [1]\n[vary]\n\"modle.kernel\" = [\"cubic\"]\n",
       {"study.toml:4", "did you mean 'model.kernel'"}},
      {"seeds = [1]\n[vary]\n\"model.kernle\" = [\"cubic\"]\n",
       {"study.toml:4: vary.model.kernle", "did you mean 'model.kernel'"}},
      {"seeds = [1]\n[vary]\n\"model.method\" = [\"tricubic\"]\n",
       {"study.toml:4: vary.model.method", "unknown key"}},
      {"seeds = [1]\n[vary]\npolicy = [\"fifo\", \"fifo\"]\n", {"study.toml:4: vary.policy", "'fifo' twice"}},
      {"seeds = [1]\n[vary]\npolicy = [\"fifo\", \"nearst\"]\n",
       {"study.toml:4: vary.policy", "'nearst'", "'nearest'"}},
      {"seeds = [1]\n[vary]\nworkers = [0, 2]\n", {"study.toml:4: vary.workers", "is 0"}},
      {"seeds = [1]\n[vary]\ndevice = [\"path:prss\"]\n", {"study.toml:4: vary.device", "prss"}},
      {"seeds = [1]\n[vary]\ndevice = [\"trace:none.csv\"]\n", {"study.toml:4: vary.device", "none.csv"}},
      {"seeds = [1]\n[vary]\ncost = [\"constant:0\"]\n", {"study.toml:4: vary.cost", "constant:0"}},
      {"seeds = [1]\n[vary]\nswitch = [\"soft\"]\n", {"study.toml:4: vary.switch", "'soft'"}},
      {"seeds = [1]\n[session]\npolicy = \"fifo\"\n[vary]\npolicy = [\"nearest\"]\n",
       {"study.toml:4: session.policy", "varied", "study.toml:6"}},
      {"seeds = [1]\n[model]\nselect = \"label\"\n[vary]\nselect = [\"nearest\"]\n",
       {"study.toml:4: model.select", "varied"}},
      {"seeds = [1]\n[vary]\n\"session.jnd\" = [{ share = 0.1 }]\n\"session.jnd.share\" = [0.07]\n",
       {"study.toml:5", "expected it once"}},
      {"seeds = [1]\n[vary]\n\"session.seed\" = [1]\n", {"study.toml:4", "seeds of the study"}},
      {"seeds = [1]\n[vary]\n\"session.clock\" = [\"virtual\", \"real\"]\n", {"study.toml:4", "virtual"}},
      {"seeds = [1]\n[session]\nclock = \"real\"\n", {"study.toml:4: session.clock", "'virtual'"}},
      {"seeds = [1]\n[vary]\ntarget_load = [1, 0]\n", {"study.toml:4: vary.target_load", "above 0"}},
      {"seeds = [1]\n[vary]\ntarget_load = [1, 1e9]\n",
       {"study.toml:4: vary.target_load", "1000000000", "at most"}},
      {"seeds = [1]\n[session]\nlatency = 10.0\n[vary]\ntarget_load = [1]\n",
       {"study.toml:6: vary.target_load", "message of 10 s"}},
      {"seeds = [1]\n[vary]\ntarget_load = [1]\ncost = [\"paper\"]\n",
       {"study.toml:5: vary.cost", "target_load"}},
      {"seeds = 3\n[vary]\npolicy = [\"nearest\"]\n", {"seeds", "is 3", "list"}},
      {"seeds = [1]\n[vary]\nspeed = [0.1]\n", {"study.toml:4: vary.speed", "names its speed already"}},
      {"seeds = [1]\nbaseline = \"error\"\n[vary]\npolicy = [\"fifo\"]\n",
       {"study.toml:3: baseline", "'error'", "fifo"}},
      {"seeds = [1]\n[sustained]\nlow = 3.0\n", {"sustained", "not below"}},
      {"seeds = [1]\n[sustained]\nhihg = 3.0\n", {"did you mean 'high'"}},
      {"seeds = [1]\n[session]\nseconds = 1.0\n[sustained]\n", {"seconds", "fixed"}},
      {"seeds = [1]\nstep = []\n", {"step", "[[step]]"}},
      {"seeds = [1]\n[[step]]\npolicy = \"fifo\"\n", {"step.name", "missing"}},
      {"seeds = [1]\n[[step]]\nname = \"a\"\npolicy = \"fifo\"\n[vary]\npolicy = [\"nearest\"]\n",
       {"policy", "changed by a step"}},
      {"seeds = [1]\n[vary]\nmodel = [\"cubic\"]\n", {"study.toml:4: vary.model", "tables of keys"}},
      {"seeds = [1]\n[vary]\nmodel = [{ kernel = \"cubic\" }]\n\"model.kernel\" = [\"cubic\"]\n",
       {"study.toml:5", "expected it once"}},
      {"seeds = [1]\n[vary]\n\"body.elements\" = [100]\n\"body.elements\" = [200]\n",
       {"study.toml:5", "not TOML"}},
  };
  for (const Bad& bad : all) check_refused(folder, bad);
  CHECK(refusal([&] {
          read_study(folder.write("s.toml", "scene = \"no.toml\"\nseeds = [1]\n"), {});
        }).find("no.toml") != std::string::npos);
  CHECK_FALSE(refusal([&] { read_study(folder.path / "none.toml", {}); }).empty());
  const std::vector<std::string> set{"session.policy=fifo"};
  CHECK(refusal([&] {
          read_study(folder.study("seeds = [1]\n[vary]\npolicy = [\"fifo\"]\n"), set);
        }).find("--set session.policy") == 0);
}

TEST_CASE("what a session of any cell would refuse is refused beforehand, with the place in the study") {
  const Folder folder;
  folder.write("far.csv", "t,x,y,z\n0,0,0,0\n1,1,1,0\n");
  folder.write("good.csv", "t,x,y,z\n0.1,0,0,0\n");
  folder.write("bad.csv", "t,x,y,z\n0.1,0,0,0\n0.2,nan,0,0\n");
  folder.write("distant.csv", "t,x,y,z\n0.1,0,0,0\n0.2,0,0,7\n");
  const std::string vary = "seeds = [1]\n[session]\nseconds = 1.0\n[vary]\n",
                    arrivals = "\"session.arrivals\" = ";
  const std::vector<Bad> all{
      {vary + "policy = [\"nearest\", \"clairvoyant\"]\ndevice = [\"hand:touch,target=circle\"]\n",
       {"study.toml:6: vary.policy: ", "knows the motion"}},
      {vary + "device = [\"path:circle\", \"trace:far.csv\"]\n",
       {"study.toml:6: vary.device: ", "far.csv", "from rest"}},
      {vary + "device = [\"path:circle,amplitude=10,speed=2\"]\n",
       {"study.toml:6: vary.device: ", "from rest"}},
      {vary + arrivals + "[\"good.csv\", \"bad.csv\"]\n",
       {"study.toml:6: vary.session.arrivals: ", "bad.csv:3", "'nan'"}},
      {vary + arrivals + "[\"good.csv\", \"distant.csv\"]\n",
       {"study.toml:6: vary.session.arrivals: ", "distant.csv:3", "7 m from rest"}},
      {vary + "\"session.latency\" = [0.0, 1e9]\n", {"study.toml:6: vary.session.latency: is 1000000000"}},
      {"seeds = [1]\n[session]\nseconds = 1e9\n[vary]\npolicy = [\"nearest\"]\n",
       {"study.toml:4: session.seconds: is 1000000000"}},
      {"seeds = [1]\n[session]\nseconds = 1e-5\n[vary]\npolicy = [\"nearest\"]\n",
       {"study.toml:4: session.seconds: is shorter"}},
      {vary + "\"session.placement\" = [\"lattice\", \"path\"]\n\"model.neighbours\" = [25, 100000]\n",
       {"study.toml:7: vary.model.neighbours: is 100000", "GB"}},
      {"seeds = [1]\n[session]\ndevice = \"path:circle\"\n[sustained]\ntravel = 1e6\n[vary]\npolicy = "
       "[\"nearest\"]\n",
       {"study.toml:5: sustained: session.seconds is 2"}},
      {"seeds = [1]\n[session]\narrivals = \"good.csv\"\n[vary]\ntarget_load = [1.0]\n",
       {"study.toml:6: vary.target_load: has no effect", "study.toml:4: session.arrivals"}},
      {"seeds = [1]\n[session]\narrivals = \"good.csv\"\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n",
       {"study.toml:6: vary.policy: ", "study.toml:4: session.arrivals"}},
      {"seeds = [1]\n[session]\narrivals = \"good.csv\"\n[vary]\npolicy = [\"fifo\"]\n",
       {"study.toml:6: vary.policy: has no effect", "study.toml:4: session.arrivals"}},
      {"seeds = [1]\n[session]\narrivals = \"good.csv\"\npreempt = false\n",
       {"study.toml:5: session.preempt: has no effect", "study.toml:4: session.arrivals"}},
      {"seeds = [1]\n[session]\nrest_first = true\n[[step]]\nname = \"a\"\n\"session.arrivals\" = "
       "\"good.csv\"\n",
       {"study.toml:4: session.rest_first: has no effect", "study.toml:7: step.session.arrivals"}},
      {"seeds = [1]\n[session]\narrivals = \"good.csv\"\ndevice = \"path:press\"\n[sustained]\ntravel = "
       "0.05\n",
       {"study.toml:6: sustained: has no effect", "study.toml:4: session.arrivals"}},
      {vary + arrivals + "[\"\"]\n", {"study.toml:6: vary.session.arrivals: is ''"}},
      {vary + arrivals + "[\"good.csv\", \"./good.csv\"]\n",
       {"study.toml:6: vary.session.arrivals: ", "the same as 'good.csv'"}},
      {vary + "device = [\"trace:good.csv,scale=0.5\", \"trace:../" + folder.path.filename().string() +
           "/good.csv,scale=0.5\"]\n",
       {"study.toml:6: vary.device: ", "the same as 'trace:good.csv,scale=0.5'"}},
      {vary + "workers = [2, 0x2]\n", {"study.toml:6: vary.workers: holds '2' twice"}},
      {vary + "target_load = [1, 1.0]\n",
       {"study.toml:6: vary.target_load: holds '1.0', which is the same as '1'"}},
      {"seeds = [1]\n[sustained]\ntravel = 0.05\n", {"study.toml:3: sustained: ", "names its speed already"}},
      {"seeds = [1]\n[session]\ndevice = \"trace:good.csv\"\n[sustained]\n",
       {"study.toml:5: sustained: ", "no speed to set"}},
      {"seeds = [1]\n[session]\ndevice = \"hand:touch,target=circle\"\n[sustained]\n",
       {"study.toml:5: sustained: ", "no speed to set"}},
      {"seeds = [1]\n[session]\ndevice = \"path:press\"\n[vary]\ntarget_load = [1]\n[sustained]\n",
       {"study.toml:7: sustained: ", "study.toml:6: vary.target_load"}},
      {"seeds = [1]\n[session]\ndevice = \"path:press\"\n[vary]\nspeed = [0.1, 1e9]\n",
       {"study.toml:6: vary.speed: ", "at most 1000"}},
      {vary + "\"contact.group\" = [\"contact\", \"clamp\"]\n",
       {"study.toml:6: vary.contact.group: node ", "is clamped"}},
      {"seeds = [1]\n[contact]\ngroup = \"contact\"\nnode = 3\n",
       {"study.toml:5: contact.node: ", "study.toml:4", "one of the two"}},
      {"seeds = [1]\n[contact]\nradius = 0.01\n",
       {"study.toml:4: contact.radius: none given", "exactly one of"}},
      {vary + "\"clamp.nodes\" = [[1]]\n", {"study.toml:6: vary.clamp.nodes: ", "on one line"}},
      {vary + "\"body.elements\" = [5]\n", {"study.toml:6: vary.body.elements: ", "cannot be met"}},
      {vary + "\"body.length\" = [0.1, 1e-300]\n", {"study.toml:6: vary.body.length: is 1e-300"}},
      {vary + "\"body.length\" = [0.1, 0.001]\n", {"study.toml:6: vary.body.length: ", "from rest"}},
      {vary + "\"state_space.box\" = [[[0.1, 0, 0], [0, 1, 1]]]\n",
       {"study.toml:6: vary.state_space.box: is inverted", "[0.1, 0, 0]"}},
  };
  for (const Bad& bad : all) check_refused(folder, bad);
  // What the scene says is said with the scene's place.
  folder.write("scene.toml", [&] {
    std::ifstream in(folder.path / "scene.toml");
    std::string scene((std::istreambuf_iterator<char>(in)), {});
    return scene.replace(scene.find("path:press,speed=0.06"), 21, "path:circle,amplitude=9,speed=50");
  }());
  CHECK(refusal([&] {
          plan_study(read_study(folder.study("seeds = [1]\n[vary]\npolicy = [\"fifo\"]\n"), {}));
        }).find("scene.toml:12: session.device: ") != std::string::npos);
}

TEST_CASE(
    "what a scene holds for its own runs is passed over with a warning where a study brings the arrivals") {
  const Folder folder;
  folder.write("good.csv", "t,x,y,z\n0.1,0,0,0\n");
  const auto scene = [&](const std::string& more) {
    std::ifstream in(folder.path / "scene.toml");
    folder.write("more.toml", std::string(std::istreambuf_iterator<char>(in), {}) + more);
    return plan_study(read_study(
        folder.write(
            "s.toml",
            "scene = \"more.toml\"\nseeds = [1, 2]\n[vary]\n\"session.arrivals\" = [\"good.csv\"]\n"),
        {}));
  };
  const auto said = [](const StudyPlan& plan) {
    return std::ranges::count_if(
        plan.warnings, [](const std::string& w) { return w.find("without effect") != std::string::npos; });
  };
  CHECK(said(scene("")) == 0);
  const StudyPlan plan = scene("workers = 3\npolicy = \"fifo\"\n");
  REQUIRE(said(plan) == 1);
  CHECK_THAT(plan.warnings.back(), Catch::Contains("more.toml:14: session.workers") &&
                                       Catch::Contains("more.toml:15: session.policy") &&
                                       Catch::Contains("s.toml:4: vary.session.arrivals"));
}

TEST_CASE("steps that take turns among contacts keep the last one given") {
  const Folder folder;
  const Study study = read_study(
      folder.study("seeds = [1]\n[[step]]\nname = \"a\"\n\"contact.node\" = 40\n[[step]]\nname = \"b\"\n"
                   "\"contact.group\" = \"contact\"\n"),
      {});
  CHECK(study.axes[0].values[0].overrides == std::vector<std::string>{"contact.node=40"});
  CHECK(study.axes[0].values[1].overrides == std::vector<std::string>{"contact.group=\"contact\""});
}

TEST_CASE("a target load is met by a hand too, whose motion answers the force") {
  const Folder folder;
  const StudyPlan plan = plan_study(
      read_study(folder.study("seeds = [1, 2]\n[material]\nlaw = \"linear\"\nyoung = "
                              "20000.0\n[session]\nseconds = 6.0\ndevice = \"hand:touch,target=circle\"\n"
                              "[vary]\ntarget_load = [0.5, 1.0]\n"),
                 {}));
  std::vector<CellColumns> cells = run(plan, folder.path / "out", 2);
  REQUIRE(cells.size() == 4);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    CHECK(cell_number(cells[i], "load") == Approx(i < 2 ? 0.5 : 1.0).epsilon(0.05));
    CHECK(cells[i]["cost"] != plan.cells[i].options.workers.cost);  // that of a hand which nothing holds back
  }
  CHECK_FALSE(loads_missed(plan, cells));
  cells[3]["load"] = 1.2;
  REQUIRE(loads_missed(plan, cells));
  CHECK_THAT(*loads_missed(plan, cells), Catch::StartsWith("1 of 4 cells") && Catch::Contains("20 %"));
}

TEST_CASE("values of a study stand as they were written") {
  const Folder folder;
  const Study study =
      read_study(folder.study("seeds = [1]\n[vary]\n\"state_space.spacing\" = [\"auto\", 0.006, 2.0, 1e-7]\n"
                              "\"state_space.box\" = [[[-0.03, 0, 0], [0.1, 1, 1]]]\n"),
                 {});
  std::vector<std::string> shown;
  for (const StudyValue& value : study.axes[0].values) shown.push_back(value.text);
  CHECK(shown == std::vector<std::string>{"auto", "0.006", "2.0", "1e-07"});
  CHECK(study.axes[1].values[0].text == "[ [ -0.03, 0, 0 ], [ 0.1, 1, 1 ] ]");
  // A whole number by its value.
  const Study hexadecimal =
      read_study(folder.study("seeds = [1]\n[vary]\nworkers = [0x2, 0b11, 1_000]\n"), {});
  CHECK(hexadecimal.axes[0].values[0].text == "2");
  CHECK(hexadecimal.axes[0].values[0].overrides == std::vector<std::string>{"session.workers=2"});
  CHECK(hexadecimal.axes[0].values[1].text == "3");
  CHECK(hexadecimal.axes[0].values[2].text == "1000");
}

TEST_CASE("a study of more cells than anybody waits for is refused") {
  const Folder folder;
  std::string list = "1";
  for (int i = 2; i <= 400; ++i) list += ", " + std::to_string(i);
  const std::string said = refusal(
      [&] { read_study(folder.study("seeds = [" + list + "]\n[vary]\nworkers = [" + list + "]\n"), {}); });
  CHECK(said.find("1.6e+05") != std::string::npos);
}

TEST_CASE("traces named in a study are found beside it, and their content is part of a cell") {
  const Folder folder;
  fs::create_directories(folder.path / "sub");
  folder.write("sub/hand.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-0.01\n");
  const fs::path file = folder.write(
      "sub/study.toml",
      "scene = \"../scene.toml\"\nseeds = [1]\n[vary]\ndevice = [\"trace:hand.csv,scale=0.5\"]\n");
  const StudyPlan before = plan_study(read_study(file, {}));
  CHECK(before.study.axes[0].values[0].text == "trace:hand.csv,scale=0.5");
  CHECK(before.cells[0].options.motion.device == "trace:sub/hand.csv,scale=0.5");
  CHECK(plan_study(read_study(file, {})).cells[0].key == before.cells[0].key);
  folder.write("sub/hand.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-0.012\n");
  CHECK(plan_study(read_study(file, {})).cells[0].key != before.cells[0].key);
}

TEST_CASE("cells share a body and differ in their keys") {
  const Folder folder;
  const StudyPlan plan = plan_study(read_study(
      folder.study("seeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"fifo\"]\nworkers = [1, 2]\n"), {}));
  REQUIRE(plan.cells.size() == 8);
  std::set<std::string> keys;
  for (const StudyCell& cell : plan.cells) keys.insert(cell.key);
  CHECK(keys.size() == 8);
  for (const Scene& scene : plan.scenes) CHECK(scene.body == plan.scenes.front().body);
  CHECK(plan.cells[0].options.clock.kind == Clock::virtual_time);
  CHECK(plan.cells[5].options.planning.policy == "fifo");
  CHECK(plan.cells[5].options.workers.count == 1);
  CHECK(plan.cells[5].seed == 2);
}

TEST_CASE("--set gives what a study fixes another value, and is refused for what varies") {
  const Folder folder;
  const auto file =
      folder.study("seeds = [3]\n[session]\nworkers = 3\n[vary]\npolicy = [\"fifo\", \"nearest\"]\n");
  const std::vector<std::string> five{"session.workers=5"}, policy{"session.policy=\"fifo\""};
  for (const StudyCell& cell : plan_study(read_study(file, five)).cells)
    CHECK(cell.options.workers.count == 5);
  CHECK(refusal([&] { read_study(file, policy); }).find("varied") != std::string::npos);
}

TEST_CASE("a target load is the load that the session measures") {
  const Folder folder;
  const StudyPlan plan = plan_study(read_study(
      folder.study(
          "seeds = [3]\n[session]\nseconds = 1.0\nrest_known = true\n[vary]\n"
          "\"session.latency\" = [0.0, 0.001]\n\"session.batch\" = [1, 3]\ntarget_load = [0.5, 2.0]\n"),
      {}));
  REQUIRE(plan.cells.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) {
    StudyCell cell = plan.cells[i];
    CHECK(cell.options.workers.cost.starts_with("lognormal:"));
    // A fixed cost of the same mean: what is measured is then exactly what was asked for.
    const double demand = states_needed_per_second(plan.scenes[i], cell.options),
                 target = i % 2 == 0 ? 0.5 : 2.0;
    const double b = cell.options.planning.batch, share = cell.options.workers.batch_share;
    if (b > 1 && i % 2 == 1) continue;  // so few jobs that the last, cut short, counts
    const double job = target * cell.options.workers.count * b / demand - 2 * cell.options.workers.latency;
    cell.options.workers.cost = "constant:" + std::to_string(job / (1 + (b - 1) * share));
    const SessionInput input = session_input(plan.scenes[i]);
    const CellColumns columns = cell_columns(run_cell(plan, cell, input, {}), input, cell.options);
    CHECK(cell_number(columns, "load") ==
          Approx(target).epsilon(b > 1 ? 0.05 : 0.01));  // a batch may be cut short
  }
}

TEST_CASE("cells.csv has the same bytes for 1 and 2 threads, after a break, and only missing cells are run") {
  const Folder folder;
  const std::string varied =
      "[vary]\npolicy = [\"nearest\", \"clairvoyant\"]\ncost = [\"constant:0.02\", \"paper\"]\n";
  const StudyPlan plan = plan_study(read_study(folder.study("seeds = [1, 2]\n" + varied), {}));
  std::size_t ran = 0;
  const std::vector<CellColumns> first = run(plan, folder.path / "one", 1, &ran);
  CHECK(ran == 8);
  const std::string table = cells_csv(plan.study, first);
  CHECK(cells_csv(plan.study, run(plan, folder.path / "two", 2)) == table);

  run(plan, folder.path / "one", 2, &ran);
  CHECK(ran == 0);
  // One record lost, one cut in the middle as no kill of ours leaves it, one of a foreign hand.
  const auto record = [&](std::size_t i) {
    return folder.path / "one" / "cells" / (plan.cells[i].key + ".json");
  };
  fs::remove(record(0));
  std::ifstream in(record(3));
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::ofstream(record(3)) << text.substr(0, text.size() / 2);
  std::ofstream(record(5)) << "{\"key\": \"other\", \"columns\": {}}";
  const std::vector<CellColumns> again = run(plan, folder.path / "one", 2, &ran);
  CHECK(ran == 3);
  CHECK(cells_csv(plan.study, again) == table);

  const StudyPlan wider = plan_study(read_study(folder.study("seeds = [2, 3]\n" + varied), {}));
  run(wider, folder.path / "one", 1, &ran);
  CHECK(ran == 4);

  // A header, then as many values as names in every row; nothing of the wall clock.
  std::istringstream lines(table);
  std::string header;
  std::getline(lines, header);
  CHECK(header.starts_with("policy,cost,seed,clock,seconds,frames,"));
  CHECK(header.find("error.first_visit.within_jnd") != std::string::npos);
  CHECK(header.find(",policy") == std::string::npos);
  CHECK(header.find("provenance") == std::string::npos);
  for (const CellColumns& cell : first) CHECK(cell.at("wall_seconds").is_null());
  // Clairvoyant rows are the bound that regret is counted from.
  CHECK(cell_number(first[4], "regret.first_visit.within_jnd") == 0);
  CHECK(cell_number(first[0], "regret.within_jnd") ==
        Approx(cell_number(first[4], "error.within_jnd") - cell_number(first[0], "error.within_jnd")));
}

TEST_CASE("a second writer to the same folder is refused") {
  const Folder folder;
  const StudyPlan plan = plan_study(read_study(folder.study("seeds = [1]\n"), {}));
  run(plan, folder.path / "out", 1);
  fs::permissions(folder.path / "out" / "cells" / "lock", fs::perms::owner_all);
  const std::string hold =
      "flock -n '" + (folder.path / "out/cells/lock").string() + "' -c 'echo held; sleep 3'";
  if (!test::has_command("flock")) return test::skip("flock is not installed");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> holder(popen(hold.c_str(), "r"), pclose);
  char line[16];
  REQUIRE(std::fgets(line, sizeof line, holder.get()) != nullptr);
  CHECK(refusal([&] { run(plan, folder.path / "out", 1); }).find("another study") != std::string::npos);
}

TEST_CASE("text with commas and quotes survives in cells.csv") {
  const Folder folder;
  const Study study =
      read_study(folder.study("seeds = [1]\n[vary]\ndevice = [\"path:press,speed=0.06\"]\n"), {});
  CellColumns cell = CellColumns::object();
  cell["a"] = "say \"so\", twice";
  cell["b"] = nullptr;
  cell["c"] = 0.1;
  CHECK(cells_csv(study, {cell}) ==
        "device,seed,a,b,c\n\"path:press,speed=0.06\",1,\"say \"\"so\"\", twice\",,0.1\n");
}

TEST_CASE("the highest sustained speed is found within 5 %") {
  const SustainedOptions options{.low = 0.01, .high = 2.0};
  for (const double truth : {0.0123, 0.05, 0.31, 1.3}) {
    double cost = 0;  // of all trials, over that of one at the speed found: slow runs are long
    const SustainedSpeed found = sustained_speed(options, [&](double v) {
      cost += 1 / v;
      return v <= truth ? 0.96 : 0.90;
    });
    CHECK(cost * found.speed < 8);
    CHECK(found.speed <= truth);
    CHECK(found.speed > truth / 1.06);
    CHECK_FALSE(found.capped);
    CHECK(found.trials < 20);
  }
  const SustainedSpeed all = sustained_speed(options, [](double) { return 1.0; });
  CHECK(all.speed == 2.0);
  CHECK(all.capped);
  CHECK(sustained_speed(options, [](double) { return 0.0; }).speed == 0);
  // A single failure below the limit does not end the search.
  CHECK(sustained_speed(options, [](double v) {
          return v > 0.035 && v < 0.045 ? 0.5 : v <= 0.5 ? 1.0 : 0.0;
        }).speed > 0.45);
}

TEST_CASE("rankings average settings within a trace and seed, and pair") {
  const Folder folder;
  const Study study = read_study(folder.study("seeds = [1, 2, 3]\nbaseline = \"nearest\"\n[vary]\npolicy = "
                                              "[\"nearest\", \"coverage\", \"fifo\"]\n"
                                              "device = [\"path:press\", \"path:circle\", \"path:line\", "
                                              "\"path:reach\"]\n\"model.neighbours\" = [10, 20]\n"),
                                 {});
  // Traces differ widely, coverage gains 0.1 with 10 neighbours and 0.02 with 20; fifo is the same as nearest
  // but for noise.
  const auto cells = made_up(study, [](const std::vector<std::size_t>& c, std::uint64_t seed) {
    const double trace = 0.2 * static_cast<double>(c[1]),
                 noise = 0.001 * std::sin(10.0 * static_cast<double>(seed + 7 * c[1] + 31 * c[0]));
    return trace + noise + (c[0] == 1 ? (c[2] == 0 ? 0.1 : 0.02) : 0.0);
  });
  const std::vector<AxisRanking> ranked = rankings(study, cells);
  REQUIRE(ranked.size() == 3);
  CHECK(ranked[0].ranking.blocks == 12);
  CHECK(ranked[0].ranking.ranked.front().level == 1);
  CHECK(ranked[0].ranking.ranked[2].to_best.student.mean == Approx(-0.06).margin(0.003));
  const std::vector<Contrast> compared = contrasts(study, cells, primary_metric(study));
  REQUIRE(compared.size() == 6);  // two policies: everywhere, and at either number of neighbours
  CHECK(compared[0].comparison.verdict() == 1);
  CHECK(compared[0].comparison.student.mean == Approx(0.06).margin(0.003));
  CHECK(compared[1].comparison.verdict() == 0);
  CHECK(compared[2].comparison.student.mean == Approx(0.1).margin(0.003));
  CHECK(compared[4].comparison.student.mean == Approx(0.02).margin(0.003));
  CHECK(compared[4].comparison.groups == 4);
  // Where less is better who has less has won.
  const std::vector<Contrast> errors = contrasts(study, cells, second_metric(study));
  CHECK(errors[0].comparison.student.mean == Approx(-0.06).margin(0.003));
  for (const auto& told : {ranking_json(study, ranked, compared)["contrasts"][0],
                           ranking_json(study, ranked, errors)["contrasts"][0]}) {
    CHECK(told["value"] == "coverage");
    CHECK(told["won"] == told["pairs"]);
    CHECK(told["lost"] == 0);
    CHECK(told["verdict"] == 1);
  }
}

TEST_CASE("steps are each compared with the one before") {
  const Folder folder;
  const Study study = read_study(folder.study("seeds = [1, 2, 3, 4]\n[[step]]\nname = \"a\"\npolicy = "
                                              "\"fifo\"\n[[step]]\nname = \"b\"\npolicy = \"nearest\"\n"
                                              "[[step]]\nname = \"c\"\npolicy = \"coverage\"\n"),
                                 {});
  const auto cells = made_up(study, [](const std::vector<std::size_t>& c, std::uint64_t seed) {
    return 0.1 * static_cast<double>(c[0]) + 0.01 * static_cast<double>(seed % 2);
  });
  const std::vector<Contrast> compared = contrasts(study, cells, primary_metric(study));
  REQUIRE(compared.size() == 2);
  CHECK(compared[1].a == 2);
  CHECK(compared[1].b == 1);
  CHECK(compared[1].comparison.student.mean == Approx(0.1));
}

// ---- the command
// ---------------------------------------------------------------------------------------------------

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
  shop.write("scene.toml", test::beam_scene("[session]\nseconds = 0.8\nrest_first = false\n"));
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
  CHECK_THAT(single.out, Catch::Contains("bootstrap none, Student's none: not shown"));
}

TEST_CASE("sustained speeds: the report says what counts where not even the lowest holds") {
  const Folder folder;
  const StudyPlan plan =
      plan_study(read_study(folder.study("seeds = [1, 2]\n[session]\ndevice = \"path:press\"\n[vary]\npolicy "
                                         "= [\"nearest\", \"fifo\"]\n[sustained]\nlow = 0.02\n"),
                            {}));
  StudyResult result;
  for (const double speed : {0.0, 0.08, 0.16, 0.16}) {
    CellColumns cell = CellColumns::object();
    cell["sustained.speed"] = speed;
    result.cells.push_back(cell);
  }
  const auto page = [&] {
    return study_page(plan, result, rankings(plan.study, result.cells),
                      contrasts(plan.study, result.cells, primary_metric(plan.study)));
  };
  const std::vector<std::string> notes = sustained_notes(plan.study, result.cells);
  REQUIRE(notes.size() == 2);
  CHECK_THAT(notes[0], Catch::Contains("at its own sustained speed"));
  CHECK_THAT(notes[1], Catch::Contains("In 1 of 4 cells") && Catch::Contains("20 mm/s") &&
                           Catch::Contains("lower bounds"));
  for (const std::string& note : notes) CHECK_THAT(page(), Catch::Contains(note));
  // It counts as the lowest: seed 1 is 0.16 over 0.02, seed 2 0.16 over 0.08.
  const std::vector<Contrast> compared = contrasts(plan.study, result.cells, primary_metric(plan.study));
  REQUIRE_FALSE(compared.empty());
  CHECK(std::abs(compared[0].comparison.student.mean) == Approx(0.5 * (std::log(8) + std::log(2))));
  result.cells[0]["sustained.speed"] = 0.02;
  CHECK(sustained_notes(plan.study, result.cells).size() == 1);
  CHECK_THAT(page(), !Catch::Contains("not even the lowest"));
  CHECK(
      sustained_notes(plan_study(read_study(folder.study("seeds = [1]\n"), {})).study, result.cells).empty());
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
    return shop.shell("mkdir -p out; " + test::executable() + " study study.toml -o out --threads 1 " +
                      option + " & p=$!; while [ $(ls out/cells 2>/dev/null | grep -c json) -lt " +
                      std::to_string(cells) +
                      " ] && kill -0 $p 2>/dev/null; do sleep 0.02; done; kill -INT $p; wait $p");
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
  shop.shell("mkdir out && (" + test::executable() +
             " study study.toml -o out --quiet --threads 1 & p=$!; "
             "while [ $(ls out/cells 2>/dev/null | grep -c json) -lt 2 ] && kill -0 $p 2>/dev/null; do sleep "
             "0.02; done; kill -9 $p; wait $p)");
  const auto count = std::stoul(shop.shell("ls out/cells | grep -c '^[0-9a-f]*[.]json$'").out);
  CHECK(count >= 2);
  const auto resumed = shop.forefeel("study study.toml -o out --json");
  REQUIRE(resumed.code == 0);
  CHECK(resumed.json()["resumed"] == count);
  REQUIRE(shop.forefeel("study study.toml -o whole --quiet --threads 1").code == 0);
  CHECK(shop.shell("cmp out/cells.csv whole/cells.csv").code == 0);
}
