// Study files: their meaning; every contradiction is refused in one line that names the place.

#include "apps/study/planned_study.hpp"
#include "tests/apps/study_fixture.hpp"

TEST_CASE("a study: axes in the order of the file, the first slowest, the seed fastest") {
  const StudyFixture folder;
  const StudyFile study = read_study(
      folder.study("seeds = [4, 2]\n[session]\nseconds = 0.5\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n"
                   "\"model.neighbours\" = [8, 12, 16]\nselect = [\"nearest\"]\n"),
      {});
  REQUIRE(study.axes.size() == 3);
  CHECK(study.axes[0].column == "policy");
  CHECK(study.axes[1].column == "model.neighbours");
  CHECK(study.study().combinations() == 6);
  CHECK(study.study().cells() == 12);
  CHECK(study.study().choice(0) == std::vector<std::size_t>{0, 0, 0});
  CHECK(study.study().choice(1) == std::vector<std::size_t>{0, 1, 0});
  CHECK(study.study().choice(5) == std::vector<std::size_t>{1, 2, 0});
  const std::vector<std::string> overrides = study.overrides(study.study().choice(4));
  const std::set<std::string> given(overrides.begin(), overrides.end());
  CHECK(given == std::set<std::string>{"session.seconds=0.5", "session.policy=\"fifo\"",
                                       "model.neighbours=12", "session.select=\"nearest\""});
}

TEST_CASE("a list of scenes is the last axis") {
  const StudyFixture folder;
  folder.write("other.toml", "[body]\nphantom = \"beam\"\n");
  const auto list = [&](const std::string& scenes) {
    return folder.write("list.toml",
                        "scene = " + scenes + "\nseeds = [1]\n[vary]\npolicy = [\"nearest\", \"fifo\"]\n");
  };
  const StudyFile study = read_study(list("[\"scene.toml\", \"other.toml\"]"), {});
  REQUIRE(study.axes.size() == 2);
  CHECK(study.axes[1].column == "scene");
  CHECK(study.axes[1].values[0].text == "scene");
  const std::vector<std::size_t> second = study.study().choice(1);
  CHECK(study.scene_of(second).filename() == "other.toml");
  CHECK(study.scene.filename() == "scene.toml");
  CHECK_THAT(error_of([&] { read_study(list("[]"), {}); }), Contains("scene: missing"));
  CHECK_THAT(error_of([&] { read_study(list("[\"scene.toml\", 3]"), {}); }),
             Contains("list.toml:1: scene: is 3"));
  CHECK_THAT(error_of([&] { read_study(list("[\"scene.toml\", \"none.toml\"]"), {}); }),
             Contains("no such file"));
  CHECK_THAT(error_of([&] { read_study(list("[\"scene.toml\", \"scene.toml\"]"), {}); }),
             Contains("holds 'scene' twice"));
  fs::create_directories(folder.path / "more");
  folder.write("more/third.toml", "[body]\nphantom = \"beam\"\n");
  CHECK_THAT(error_of([&] { read_study(list("[\"scene.toml\", \"more/third.toml\"]"), {}); }),
             Contains("another folder"));
}

TEST_CASE("keys of one section may change together, under a name") {
  const StudyFixture folder;
  const StudyFile study =
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
  const StudyFixture folder;
  const StudyFile study = read_study(
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

// Checks that the file is refused in one line that contains every word.
void check_refused(const StudyFixture& folder, const Bad& bad) {
  const std::string said = error_of([&] { plan_study(read_study(folder.study(bad.text), {})); });
  INFO(bad.text << "said: " << said);
  CHECK_FALSE(said.empty());
  CHECK_THAT(said, !Contains("\n"));
  for (const std::string& word : bad.said) CHECK_THAT(said, Contains(word));
}

}  // namespace

TEST_CASE("whatever contradicts itself or cannot run is one line that names the place") {
  const StudyFixture folder;
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
  CHECK_THAT(error_of([&] { read_study(folder.write("s.toml", "scene = \"no.toml\"\nseeds = [1]\n"), {}); }),
             Contains("no.toml"));
  CHECK_FALSE(error_of([&] { read_study(folder.path / "none.toml", {}); }).empty());
  const std::vector<std::string> set{"session.policy=fifo"};
  CHECK(error_of([&] {
          read_study(folder.study("seeds = [1]\n[vary]\npolicy = [\"fifo\"]\n"), set);
        }).find("--set session.policy") == 0);
}

TEST_CASE("what a session of any cell would refuse is refused beforehand, with the place in the study") {
  const StudyFixture folder;
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
  // An error in the scene names the place in the scene.
  folder.write("scene.toml", [&] {
    std::ifstream in(folder.path / "scene.toml");
    std::string scene((std::istreambuf_iterator<char>(in)), {});
    return scene.replace(scene.find("path:press,speed=0.06"), 21, "path:circle,amplitude=9,speed=50");
  }());
  CHECK_THAT(error_of([&] {
               plan_study(read_study(folder.study("seeds = [1]\n[vary]\npolicy = [\"fifo\"]\n"), {}));
             }),
             Contains("scene.toml:12: session.device: "));
}

TEST_CASE(
    "what a scene holds for its own runs is passed over with a warning where a study brings the arrivals") {
  const StudyFixture folder;
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
  const auto said = [](const PlannedStudy& plan) {
    return std::ranges::count_if(
        plan.warnings, [](const std::string& w) { return w.find("without effect") != std::string::npos; });
  };
  CHECK(said(scene("")) == 0);
  const PlannedStudy plan = scene("workers = 3\npolicy = \"fifo\"\n");
  REQUIRE(said(plan) == 1);
  CHECK_THAT(plan.warnings.back(), Contains("more.toml:14: session.workers", "more.toml:15: session.policy",
                                            "s.toml:4: vary.session.arrivals"));
}

TEST_CASE("steps that take turns among contacts keep the last one given") {
  const StudyFixture folder;
  const StudyFile study = read_study(
      folder.study("seeds = [1]\n[[step]]\nname = \"a\"\n\"contact.node\" = 40\n[[step]]\nname = \"b\"\n"
                   "\"contact.group\" = \"contact\"\n"),
      {});
  CHECK(study.axes[0].values[0].overrides == std::vector<std::string>{"contact.node=40"});
  CHECK(study.axes[0].values[1].overrides == std::vector<std::string>{"contact.group=\"contact\""});
}

TEST_CASE("values of a study stand as they were written") {
  const StudyFixture folder;
  const StudyFile study =
      read_study(folder.study("seeds = [1]\n[vary]\n\"state_space.spacing\" = [\"auto\", 0.006, 2.0, 1e-7]\n"
                              "\"state_space.box\" = [[[-0.03, 0, 0], [0.1, 1, 1]]]\n"),
                 {});
  std::vector<std::string> shown;
  for (const StudyFileValue& value : study.axes[0].values) shown.push_back(value.text);
  CHECK(shown == std::vector<std::string>{"auto", "0.006", "2.0", "1e-07"});
  CHECK(study.axes[1].values[0].text == "[ [ -0.03, 0, 0 ], [ 0.1, 1, 1 ] ]");
  // A whole number by its value.
  const StudyFile hexadecimal =
      read_study(folder.study("seeds = [1]\n[vary]\nworkers = [0x2, 0b11, 1_000]\n"), {});
  CHECK(hexadecimal.axes[0].values[0].text == "2");
  CHECK(hexadecimal.axes[0].values[0].overrides == std::vector<std::string>{"session.workers=2"});
  CHECK(hexadecimal.axes[0].values[1].text == "3");
  CHECK(hexadecimal.axes[0].values[2].text == "1000");
}

TEST_CASE("a study of more cells than anybody waits for is refused") {
  const StudyFixture folder;
  std::string list = "1";
  for (int i = 2; i <= 400; ++i) list += ", " + std::to_string(i);
  const std::string said = error_of(
      [&] { read_study(folder.study("seeds = [" + list + "]\n[vary]\nworkers = [" + list + "]\n"), {}); });
  CHECK_THAT(said, Contains("1.6e+05"));
}

TEST_CASE("traces named in a study are found beside it, and their content is part of a cell") {
  const StudyFixture folder;
  fs::create_directories(folder.path / "sub");
  folder.write("sub/hand.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-0.01\n");
  const fs::path file = folder.write(
      "sub/study.toml",
      "scene = \"../scene.toml\"\nseeds = [1]\n[vary]\ndevice = [\"trace:hand.csv,scale=0.5\"]\n");
  const PlannedStudy before = plan_study(read_study(file, {}));
  CHECK(before.file.axes[0].values[0].text == "trace:hand.csv,scale=0.5");
  CHECK(to_text(before.plan.cells[0].options.motion.device) == "trace:sub/hand.csv,scale=0.5");
  CHECK(plan_study(read_study(file, {})).plan.cells[0].key == before.plan.cells[0].key);
  folder.write("sub/hand.csv", "t,x,y,z\n0,0,0,0\n1,0,0,-0.012\n");
  CHECK(plan_study(read_study(file, {})).plan.cells[0].key != before.plan.cells[0].key);
}

TEST_CASE("cells share a body and differ in their keys") {
  const StudyFixture folder;
  const PlannedStudy planned = plan_study(read_study(
      folder.study("seeds = [1, 2]\n[vary]\npolicy = [\"nearest\", \"fifo\"]\nworkers = [1, 2]\n"), {}));
  const StudyPlan& plan = planned.plan;
  REQUIRE(plan.cells.size() == 8);
  std::set<std::string> keys;
  for (const StudyCell& cell : plan.cells) keys.insert(cell.key);
  CHECK(keys.size() == 8);
  for (const Scene& scene : planned.scenes) CHECK(scene.body == planned.scenes.front().body);
  CHECK(plan.cells[0].options.clock.kind == Clock::virtual_time);
  CHECK(plan.cells[5].options.planning.policy.name == "fifo");
  CHECK(plan.cells[5].options.workers.count == 1);
  CHECK(plan.cells[5].seed == 2);
}

TEST_CASE("--set gives what a study fixes another value, and is refused for what varies") {
  const StudyFixture folder;
  const auto file =
      folder.study("seeds = [3]\n[session]\nworkers = 3\n[vary]\npolicy = [\"fifo\", \"nearest\"]\n");
  const std::vector<std::string> five{"session.workers=5"}, policy{"session.policy=\"fifo\""};
  for (const StudyCell& cell : plan_study(read_study(file, five)).plan.cells)
    CHECK(cell.options.workers.count == 5);
  CHECK_THAT(error_of([&] { read_study(file, policy); }), Contains("varied"));
}
