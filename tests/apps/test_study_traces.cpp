// Recordings as a factor of a study: a pattern of files stands for one device each.

#include "apps/study/planned_study.hpp"
#include "tests/apps/study_fixture.hpp"
#include "tests/support/executable.hpp"

namespace {

std::string moving(double speed) {
  std::ostringstream text;
  text << "t,x,y,z\n";
  for (int k = 0; k <= 20; ++k) text << 0.02 * k << "," << speed * 0.02 * k << ",0,0\n";
  return text.str();
}

struct Recordings : StudyFixture {
  Recordings() {
    fs::create_directories(path / "hands [1]");
    for (const std::string name : {"c", "a", "e", "b", "d"})  // not in the order of the names
      write("hands [1]/" + name + ".csv", moving(0.02));
    write("hands [1]/notes.txt", "no recording");
  }
  StudyFile with(const std::string& keys, const std::string& devices) const {
    return read_study(study("seeds = [1, 2]\n" + keys +
                            "[vary]\npolicy = [\"nearest\", \"fifo\"]\ndevice = " + devices + "\n"),
                      {});
  }
};

std::vector<std::string> devices_of(const StudyFile& study) {
  std::vector<std::string> names;
  for (const StudyFileValue& value : study.axes[1].values) names.push_back(value.text);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a pattern of recordings stands for each file, by name; halves share none and miss none") {
  const Recordings folder;
  CHECK(devices_of(folder.with("", "[\"trace:hands [[]1]/*.csv\"]")) == Names{"a", "b", "c", "d", "e"});
  const std::string pattern = "[\"trace:hands*/*.csv,scale=0.5\"]";
  CHECK(devices_of(folder.with("traces = \"all\"\n", pattern)).size() == 5);
  const Names tuning = devices_of(folder.with("traces = \"tuning\"\n", pattern));
  const Names table = devices_of(folder.with("traces = \"table\"\n", pattern));
  CHECK(tuning == Names{"a,scale=0.5", "c,scale=0.5", "e,scale=0.5"});
  CHECK(table == Names{"b,scale=0.5", "d,scale=0.5"});
  CHECK(devices_of(folder.with("", "[\"path:circle\", \"trace:hands*/[ab].c?v\"]")) ==
        Names{"path:circle", "a", "b"});

  // What runs is the file itself, and the statistics have a motion for each.
  const PlannedStudy planned = plan_study(folder.with("traces = \"table\"\n", pattern));
  REQUIRE(planned.plan.cells.size() == 8);
  const auto& motion = std::get<TraceMotion>(planned.plan.cells[2].options.motion.device.motion());
  CHECK(motion.file.filename() == "d.csv");
  CHECK(motion.file.is_relative());
  CHECK(motion.scale == 0.5);
  CHECK(is_trace_axis(planned.plan.study.axes[1]));
}

TEST_CASE(
    "patterns in a folder whose name has signs of patterns; the folder of the scene is the second choice") {
  const Recordings folder;
  folder.write("hands [1]/inner.toml",
               "scene = \"../scene.toml\"\nseeds = [1]\n[vary]\ndevice = [\"trace:*.csv\"]\n");
  const StudyFile inner = read_study(folder.path / "hands [1]/inner.toml", {});
  REQUIRE(inner.axes[0].values.size() == 5);
  CHECK(inner.axes[0].values[0].overrides == Names{"session.device=\"trace:hands [1]/a.csv\""});
  fs::create_directories(folder.path / "plans");
  folder.write("plans/far.toml",
               "scene = \"../scene.toml\"\nseeds = [1]\n[vary]\ndevice = [\"trace:hands*/b.csv\"]\n");
  CHECK(plan_study(read_study(folder.path / "plans/far.toml", {})).plan.cells.size() == 1);
}

TEST_CASE("patterns of recordings that cannot be meant are refused in one line, with exit code 2") {
  const Workshop shop;
  shop.write("scene.toml", beam_scene("[session]\nseconds = 0.3\n"));
  fs::create_directories(shop.path() / "hands");
  fs::create_directories(shop.path() / "more");
  shop.write("hands/a.csv", moving(0.02));
  shop.write("more/a.csv", moving(0.03));
  const auto refused = [&](const std::string& keys, const std::string& devices,
                           const std::vector<std::string>& said) {
    shop.write("study.toml",
               "scene = \"scene.toml\"\nseeds = [1]\n" + keys + "[vary]\ndevice = " + devices + "\n");
    check_refused(shop, "study study.toml -o out", said);
  };
  refused("", "[\"trace:none/*.csv\"]",
          {"study.toml:4: vary.device", "no file matches 'none/*.csv'", "expected recordings"});
  refused("traces = \"table\"\n", "[\"trace:hands/*.csv\"]",
          {"study.toml:5: vary.device", "matches 1 file", "at least two"});
  refused("traces = \"half\"\n", "[\"trace:hands/*.csv\"]",
          {"study.toml:3: traces", "\"half\"", "all, tuning or table"});
  refused("traces = \"table\"\n", "[\"path:circle\"]", {"study.toml:3: traces", "no effect", "pattern"});
  refused("", "[\"trace:hands/*.csv\", \"trace:more/*.csv\"]",
          {"study.toml:4: vary.device", "two files 'a'", "names that differ"});
  refused("", "[\"trace:hands/a.csv\", \"trace:hands/*.csv\"]",
          {"study.toml:4: vary.device", "holds 'trace:hands/a.csv' twice"});
}
