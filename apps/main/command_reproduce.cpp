// forefeel reproduce [WHAT]: names the scripts that repeat the paper's experiments.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/console/commands.hpp"
#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/suggest.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

struct PaperScript {
  std::string name, shows;
};

// For a reader who runs nothing: figures that extrapolation.py prints.
const char* const found =
    "Found, on a path of 6 cm: beyond all states the error grows to more than half of the force, as the "
    "paper says. "
    "Across a gap the paper's kernels jump by 1.3 to 7.6 times what a hand feels where the far side enters "
    "and the near "
    "side leaves, ours (r^5, forces and stiffness, 25 states by label) by 0.05, with an error of up to 22 %. "
    "Among "
    "thinned states the error stays below 2 %, ours below 0.5 %.";
const char* const two_pictures =
    "Two pictures are called Fig. 2: apps/paper/extrapolation.py compares with tight solves and knows 5 "
    "spacings around "
    "the path; apps/examples/fig2.py compares with the model of all states, knows 3 spacings, and draws "
    "other states.";

const std::vector<PaperScript> paper_scripts = {
    {"timing", "time to update and to evaluate a model (section 4); needs forefeel-bench"},
    {"extrapolation", "out of the known space (Figs. 1 and 2)"},
    {"damping", "states that arrive while the hand rests (Fig. 3)"},
    {"energy", "energy around closed loops"},
    {"speed", "sustained speed against the number of workers; half an hour or more"}};

int run_reproduce(const Globals& globals, const std::string& what) {
  std::vector<PaperScript> named;
  std::vector<std::string> names{"all"};
  for (const PaperScript& script : paper_scripts) {
    names.push_back(script.name);
    if (what == "all" || what == script.name) named.push_back(script);
  }
  if (named.empty())
    throw InputError("reproduce", fmt::format("'{}' is unknown{}", what, expected_instead(what, names)));
  nlohmann::ordered_json document{{"found", found}, {"figure_2", two_pictures}};
  answer(globals, found);
  for (const PaperScript& script : named) {
    const std::string file = "apps/paper/" + script.name + ".py";
    document["scripts"].push_back({{"name", script.name}, {"script", file}, {"shows", script.shows}});
    answer(globals, fmt::format("python3 {} -o DIR: {}", file, script.shows));
  }
  answer(globals, two_pictures);
  answer(
      globals,
      "Installed, apps/paper is share/forefeel/paper. Each script prints the paper's figures beside ours.");
  if (globals.json) print_json(document);
  return 0;
}

}  // namespace

void add_reproduce(CommandLine& line) {
  const auto what = std::make_shared<std::string>("all");
  Command sub = line.add("reproduce", "Name the scripts that repeat the paper's table and figures");
  sub.reads_no_scene();
  sub.runs([what](const Globals& globals) { return run_reproduce(globals, *what); });
  std::string names = "all (default)";
  for (const PaperScript& script : paper_scripts) names += ", " + script.name;
  sub.option("WHAT", *what, names);
}

}  // namespace forefeel
