// Text written by users: scenes, studies, devices and costs, and the command line.

#include <stdexcept>

#include "apps/console/command.hpp"
#include "apps/console/values.hpp"
#include "apps/scene/scene.hpp"
#include "apps/scene/scene_table.hpp"
#include "apps/scene/spec_text.hpp"
#include "apps/study/study_file.hpp"
#include "geometry/common/error.hpp"
#include "tests/fuzz/targets.hpp"

namespace forefeel::fuzz {
namespace {

constexpr const char* body_sections = R"([body]
phantom = "slab"
elements = 150
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.3
)";

constexpr const char* other_sections = R"([state_space]
spacing = 0.006
box = [[-0.012, -0.012, -0.012], [0.012, 0.012, 0.012]]
[model]
kernel = "cubic"
data = "force"
neighbours = 30
[session]
device = "path:circle,speed=0.06"
cost = "lognormal:0.1,0.5"
policy = "coverage"
seconds = 2.0
workers = 4
jnd = { share = 0.07, floor = 0.01 }
limits = { force = 5.0, slew = 1000.0 }
)";

// The input as a scene, always with the same body, because meshing is not to be fuzzed.
void read_scene(std::string_view input) {
  const std::filesystem::path file = file_of("scene.toml", body_sections + std::string(input));
  if (input.find("auto") != std::string_view::npos) return;  // would measure the spacing by solves
  static const Scene like = load_scene(file_of("scene.toml", body_sections), {}, nullptr);
  const SceneDocument document = SceneDocument::read(file, {});
  for (const char* section : {"body", "material", "clamp", "contact"})
    if (document.section_text(section) != SceneDocument::parse(body_sections, "b", {}).section_text(section))
      return;
  load_scene(file, {}, &like);
}

// Lines of --set for a scene, and a document of nothing else.
void read_overrides(std::string_view input) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at <= input.size() && lines.size() < 8;) {
    const std::size_t end = std::min(input.find('\n', at), input.size());
    lines.emplace_back(input.substr(at, end - at));
    at = end + 1;
  }
  const SceneDocument document =
      SceneDocument::parse(std::string(body_sections) + other_sections, "scene.toml", lines);
  document.text();
  document.root({"body", "material", "clamp", "contact", "state_space", "model", "session"});
}

void read_any_study(std::string_view input) {
  const StudyFile study = read_study(file_of("study.toml", input), {});
  study.study();
}

void read_specs(std::string_view input) {
  const std::string text(input.substr(std::min<std::size_t>(1, input.size())));
  switch (input.empty() ? 0 : input.front() % 5) {
    case 0:
      device_from_text(text);
      break;
    case 1:
      cost_from_text(text);
      break;
    case 2:
      part_from_text("policy", text);
      break;
    case 3:
      parse_vector(text, "--at");
      break;
    default:
      above_zero(text);
  }
}

// One word a line, of a command with options of every kind.
void read_arguments(std::string_view input) {
  std::vector<std::string> words{"forefeel", "test"};
  for (std::size_t at = 0; at <= input.size() && words.size() < 40;) {
    const std::size_t end = std::min(input.find('\n', at), input.size());
    words.emplace_back(input.substr(at, end - at));
    std::erase(words.back(), '\0');
    at = end + 1;
    if (words.back() == "--help" || words.back() == "-h" || words.back() == "--version")
      return;  // they print
  }
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  std::string text;
  std::optional<double> real;
  std::optional<long long> whole;
  std::size_t count = 0;
  std::vector<std::string> list;
  bool flag = false;
  CommandLine line("program", "A command line", [] { return std::string("1"); });
  Command command = line.add("test", "All kinds of options");
  command.runs([](const Globals&) { return 0; });
  command.option("FILE", text, "A word");
  command.option("--real", real, "A number").between(0.0, 1.0);
  command.option("--whole", whole, "A whole number");
  command.option("--count", count, "A count").between(std::size_t{1}, std::size_t{9});
  command.option("--at", list, "A list").takes_one();
  command.option("--word,-w", text, "One of these").one_of({"one", "two"});
  command.flag("--flag", flag, "A flag");
  line.run(static_cast<int>(argv.size()), argv.data());
}

}  // namespace

std::vector<Target> text_targets() {
  using Seeds = std::vector<std::string>;
  return {
      {"scene", read_scene,
       [] {
         return Seeds{other_sections, "[session]\nseconds = 1.0\n"};
       }},
      {"overrides", read_overrides,
       [] {
         return Seeds{"session.device=path:press,speed=0.1\nmodel.kernel=\"quintic\"",
                      "state_space.box=[[-1,-1,-1],[1,1,1]]", "session.limits.force=3"};
       }},
      {"study", read_any_study,
       [] {
         return Seeds{
             "scene = \"scene.toml\"\nseeds = [1, 2]\nbaseline = \"fifo\"\n[session]\nseconds = 1.0\n[vary]\n"
             "policy = [\"fifo\", \"coverage\"]\ntarget_load = [0.5, 2]\n\"model.kernel\" = [\"cubic\"]\n"
             "material = [{ name = \"soft\", young = 2e3, poisson = 0.4 }]\n",
             "scene = \"scene.toml\"\nseeds = [7]\n[[step]]\nname = \"a\"\npolicy = \"nearest\"\n"
             "[[step]]\nname = \"b\"\nworkers = 4\n[sustained]\n"};
       }},
      {"specs", read_specs,
       [] {
         return Seeds{std::string(1, '\0') + "path:circle,speed=0.06,tremor=1e-4",
                      std::string(1, '\0') + "trace:a.csv,scale=2,offset=1/2/3",
                      std::string(1, '\0') + "hand:touch,target=press,grip=light",
                      "\1lognormal:0.1,0.5",
                      "\1constant:0.01",
                      "\2mine:text,gain=2",
                      "\0030.1,-2e-3, 4",
                      "\4"
                      "1e-3"};
       }},
      {"arguments", read_arguments, [] {
         return Seeds{"a.csv\n--real\n0.5\n--json", "--at=1,2,3\n--at\n4,5,6\n--count\n3\n--flag\n-w\none",
                      "--whole\n-7\n--seed\n18446744073709551615\n--threads\n2\n--set\na.b=c\n--"};
       }}};
}

}  // namespace forefeel::fuzz
