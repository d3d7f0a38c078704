// The arrows between folders, read from the sources themselves.

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> allowed{
    {"geometry", {"geometry"}},
    {"solver", {"solver", "geometry"}},
    {"approx", {"approx", "geometry"}},
    {"scheduling", {"scheduling", "solver", "approx", "geometry"}},
    {"apps", {"apps", "scheduling", "solver", "approx", "geometry"}}};

struct Include {
  std::string file;  // relative to the root
  int line;
  std::string target;
  bool quoted;  // "…" rather than <…>
};

std::vector<Include> includes_of(const fs::path& root, const std::string& folder) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::vector<Include> found;
  for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".hpp" && extension != ".cpp") continue;
    std::ifstream in(entry.path());
    std::string text;
    for (int line = 1; std::getline(in, text); ++line)
      if (std::smatch match; std::regex_search(text, match, pattern))
        found.push_back({fs::relative(entry.path(), root).string(), line, match[2], match[1] == "\""});
  }
  return found;
}

std::string at(const Include& include) {
  return include.file + ":" + std::to_string(include.line) + " includes " + include.target;
}

// What breaks a rule, one line each.
std::vector<std::string> against_the_arrows(const fs::path& root) {
  std::vector<std::string> broken;
  for (const auto& [folder, may_see] : allowed)
    for (const Include& include : includes_of(root, folder)) {
      const std::string target = include.target.substr(0, include.target.find('/'));
      if (include.quoted &&
          (include.target.find('/') == std::string::npos || include.target.starts_with("..")))
        broken.push_back(at(include) + ", expected a path from the root");
      if ((allowed.contains(target) || target == "tests") && !may_see.contains(target))
        broken.push_back(at(include));
    }
  return broken;
}

bool is_heavy(const std::string& target) {
  return target.starts_with("CGAL/") || target == "tetgen.h";
}

// TetGen stays in .cpp files of geometry; CGAL there too, in private headers of geometry named …_cgal.hpp
// that only its .cpp files include, and in benches, which compare with it.
bool may_be_heavy(const Include& include) {
  const bool geometry = include.file.starts_with("geometry/"), source = include.file.ends_with(".cpp");
  if (include.target == "tetgen.h" || include.target.ends_with("_cgal.hpp")) return geometry && source;
  return (geometry && (source || include.file.ends_with("_cgal.hpp"))) ||
         (source && include.file.starts_with("apps/bench/"));
}

std::vector<std::string> heavy_headers_out_of_place(const fs::path& root) {
  std::vector<std::string> broken;
  for (const auto& [folder, may_see] : allowed)
    for (const Include& include : includes_of(root, folder))
      if ((is_heavy(include.target) || include.target.ends_with("_cgal.hpp")) && !may_be_heavy(include))
        broken.push_back(at(include));
  return broken;
}

}  // namespace

TEST_CASE("no include against the layers", "[layering]") {
  const std::vector<std::string> broken = against_the_arrows(forefeel::test::source_folder());
  for (const std::string& line : broken) UNSCOPED_INFO(line);
  CHECK(broken.empty());
}

TEST_CASE("CGAL and TetGen are seen where they are used, and TetGen in one file", "[layering]") {
  const std::vector<std::string> broken = heavy_headers_out_of_place(forefeel::test::source_folder());
  for (const std::string& line : broken) UNSCOPED_INFO(line);
  CHECK(broken.empty());
  std::set<std::string> tetgen;
  for (const Include& include : includes_of(forefeel::test::source_folder(), "geometry"))
    if (include.target == "tetgen.h") tetgen.insert(include.file);
  CHECK(tetgen.size() == 1);
}

TEST_CASE("the check finds what it looks for", "[layering]") {
  const forefeel::test::TemporaryFolder folder;
  const fs::path root = folder.path();
  for (const auto& [top, may_see] : allowed) fs::create_directories(root / top);
  std::ofstream(root / "approx/bad.hpp")
      << "#pragma once\n#include \"solver/equilibrium/solver.hpp\"\n  #  include <CGAL/Point_3.h>\n";
  std::ofstream(root / "solver/bad.cpp")
      << "#include \"kernels.hpp\"\n#include <tetgen.h>\n#include \"geometry/states/state.hpp\"\n";
  std::ofstream(root / "geometry/fine_cgal.hpp") << "#include <CGAL/Point_3.h>\n";
  std::ofstream(root / "geometry/fine.cpp") << "#include \"geometry/fine_cgal.hpp\"\n#include <tetgen.h>\n";
  CHECK(against_the_arrows(root).size() == 2);
  CHECK(heavy_headers_out_of_place(root).size() == 2);
}
