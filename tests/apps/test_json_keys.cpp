// The keys that commands print with --json are those that `forefeel help outputs` lists.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "apps/main/help_topics.hpp"
#include "tests/support/executable.hpp"

using namespace forefeel;
using nlohmann::json;
using test::Workshop;

namespace {

using Keys = std::set<std::string>;

// The keys of a document, joined by dots; "[]" is each entry of a list of objects.
void collect(const json& value, const std::string& path, Keys& keys) {
  if (value.is_object() && !value.empty()) {
    for (const auto& [key, inner] : value.items())
      collect(inner, path.empty() ? key : path + "." + key, keys);
  } else if (value.is_array() && !value.empty() && value[0].is_object()) {
    for (const json& entry : value) collect(entry, path + "[]", keys);
  } else {
    keys.insert(path);
  }
}

std::vector<std::string> parts_of(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

// "error.p50,p95,error.max" -> error.p50, error.p95, error.max: names without a dot take the prefix of the first.
std::vector<std::string> single(const std::string& declared) {
  std::vector<std::string> names = parts_of(declared, ',');
  const std::size_t dot = names.front().rfind('.');
  for (std::size_t i = 1; i < names.size(); ++i)
    if (names[i].find('.') == std::string::npos && dot != std::string::npos)
      names[i] = names.front().substr(0, dot + 1) + names[i];
  return names;
}

bool is_any_name(const std::string& word) {
  return std::ranges::all_of(word, [](unsigned char c) { return std::isupper(c) != 0; });
}

// "NAME" is any word, "NAME[]" any word that ends so.
bool stands_for(const std::string& declared, const std::string& word) {
  const bool list = declared.ends_with("[]");
  return word == declared ||
         (list ? word.ends_with("[]") && is_any_name(declared.substr(0, declared.size() - 2))
               : is_any_name(declared));
}

// A word in capitals stands for any name; a declared LABEL, KEY or NAME also for what is below it.
bool matches(const std::string& key, const std::string& declared) {
  const std::vector<std::string> mine = parts_of(key, '.'), theirs = parts_of(declared, '.');
  if (mine.size() < theirs.size()) return false;
  for (std::size_t i = 0; i < theirs.size(); ++i)
    if (!stands_for(theirs[i], mine[i])) return false;
  return mine.size() == theirs.size() || is_any_name(theirs.back());
}

std::vector<std::string> listed(const std::string& table) {
  std::vector<std::string> names;
  for (const HelpTopic& topic : help_topics())
    if (topic.name == "outputs")
      for (const DeclaredTable& one : tables_named(topic, table))
        for (const Declared& row : one.rows)
          for (const std::string& name : single(row.name)) names.push_back(name);
  return names;
}

// Compares the keys of these documents with a table of help. `rare`: listed, but not in these documents.
void compare(const std::string& table, const std::vector<json>& documents, const Keys& rare = {}) {
  INFO(table);
  const std::vector<std::string> declared = listed(table);
  REQUIRE(!declared.empty());
  Keys printed;
  for (const json& document : documents) collect(document, "", printed);
  Keys missing, never;
  for (const std::string& key : printed)
    if (std::ranges::none_of(declared, [&](const std::string& name) { return matches(key, name); }))
      missing.insert(key);
  for (const std::string& name : declared)
    if (!rare.contains(name) &&
        std::ranges::none_of(printed, [&](const std::string& key) { return matches(key, name); }))
      never.insert(name);
  CHECK(missing == Keys{});
  CHECK(never == Keys{});
}

}  // namespace

TEST_CASE("help lists the keys of solve, mesh, generate, evaluate and classify --json") {
  const Workshop shop;
  shop.write("beam.toml", test::beam_scene());
  const auto run = [&](const std::string& words) {
    const Workshop::Outcome done = shop.forefeel(words + " --json");
    INFO(words << "\n" << done.err);
    REQUIRE(done.code == 0);
    return done.json();
  };
  shop.write("any.toml",
             "[body]\nphantom = \"beam\"\nelements = 240\n[material]\nlaw = \"linear\"\nyoung = 5000.0\n"
             "poisson = 0.3\n[contact]\nanywhere = true\npad = 400.0\nradius = 0.012\n");
  compare("solve.json", {run("solve beam.toml --at=0,0,0.001 --discretisation-error --jet 4"),
                         run("solve any.toml --site=0.07,0.008,0.021 --at=0,0,-0.001")});
  shop.write("cube.off",
             "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n3 0 2 1\n3 0 3 2\n3 4 5 "
             "6\n3 4 6 7\n"
             "3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n");
  compare("mesh.json",
          {run("mesh --phantom beam -o beam.msh --elements 240"),
           run("mesh cube.off -o cube.msh --elements 300 --length 0.1 --toward 0.05,0.05,0.1,0.02")},
          {"labels[].label", "labels[].name", "labels[].elements", "labels[].volume", "labels[].voxels",
           "labels[].voxel_volume", "labels[].parts", "labels[].touches_border"});
  compare("generate.json", {run("generate beam.toml -o l.states")},
          {"ranks.solving", "ranks.lost", "spacing_auto", "spacing_auto.KEY"});
  shop.write("sq.csv", "sx,sy,sz,x,y,z\n0.07,0.008,0.021,0,0,-0.001\n");
  const std::string depth = " --set state_space.depth=0.002";
  compare("generate_sites.json", {run("generate any.toml -o s.states" + depth)},
          {"ranks.solving", "ranks.lost"});
  compare("evaluate_sites.json", {run("evaluate s.states --scene any.toml --points sq.csv" + depth)});
  compare("summary.json, anywhere",
          {run("session any.toml --device path:tour,depth=0.001 --clock virtual --seconds 1 --set "
               "contact.friction=0.3 -o touched" +
               depth)});
  compare("generate_error.json", {run("generate beam.toml -o e.states --error 0.1")});
  shop.write("q.csv", "x,y,z\n0.001,0.001,0\n0.002,0,0.001\n");
  std::string measured = "x,y,z,fx,fy,fz\n";
  for (int i = 0; i < 40; ++i) {
    const double x = 1e-4 * (i * 7 % 40), y = 1e-4 * (i * 11 % 40), z = 1e-4 * i;
    measured += fmt::format("{},{},{},{},{},{}\n", x, y, z, -100 * x + 1e-3 * (i % 3), -90 * y, -80 * z);
  }
  shop.write("measured.csv", measured);
  compare("evaluate.json", {run("evaluate l.states --points q.csv"),
                            run("evaluate l.states --points q.csv --method auto --no-bars"),
                            run("evaluate measured.csv --points q.csv")});
  compare("classify.json",
          {run("classify l.states --points q.csv --bars --agreement"),
           run("classify setup:gap --line=-0.03,0,0:0.03,0,0:3 --agreement")},
          {"gaps[].sides", "agreement.worst.KEY"});
}

TEST_CASE("help lists the keys of a session's summary.json") {
  const Workshop shop;
  shop.write("beam.toml", test::beam_scene());
  const std::string session =
      "session beam.toml --clock virtual --seconds 0.3 --cost constant:0.02 --quiet --json --shape-rate 30 "
      "-o ";
  const auto run = [&](const std::string& words) {
    const Workshop::Outcome done = shop.forefeel(session + words);
    INFO(words << "\n" << done.err);
    REQUIRE(done.code == 0);
    return done.json();
  };
  compare("summary.json",
          {run("path --device path:circle,speed=0.03"),
           run("hand --device hand:omega,target=circle,amplitude=0.003 --set state_space.tolerance=0.05")},
          {"spacing_auto.KEY"});
}

TEST_CASE("help lists the keys of bench solver of one state --json") {
  const Workshop shop;
  shop.write("beam.toml", test::beam_scene());
  const Workshop::Outcome done = shop.forefeel("bench solver beam.toml --states 1 --json");
  INFO(done.err);
  REQUIRE(done.code == 0);
  compare("bench_solver.json", {done.json()},
          {"failed", "states_of_the_scene", "speedup_over_one_thread", "errors_drawn", "baseline_states",
           "baseline_iterations", "baseline_failed", "multivalued", "off_branch", "peak_bytes",
           "bytes_per_thread", "cholmod_factor_bytes"});
}
