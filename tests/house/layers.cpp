#include "tests/house/layers.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <stdexcept>

namespace forefeel::house {
namespace {

namespace fs = std::filesystem;

constexpr const char* folders[] = {"geometry", "solver", "approx", "scheduling", "apps"};

constexpr const char* generated = "apps/build_info.hpp";  // made by the build, in no room

bool is_ours(const std::string& header) {
  return std::ranges::any_of(folders,
                             [&](const std::string& folder) { return header.starts_with(folder + "/"); });
}

bool matches(const std::string& pattern, const std::string& text) {
  return fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
}

std::string at(const Include& include) {
  return include.file + ":" + std::to_string(include.line) + " includes " + include.header;
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end + 1 - begin);
}

using Graph = std::map<std::string, std::map<std::string, std::string>>;  // from -> to -> one include

Graph graph_of(const std::vector<Include>& includes, const std::function<std::string(std::string)>& node) {
  Graph graph;
  for (const Include& include : includes)
    if (include.quoted && is_ours(include.header) && node(include.file) != node(include.header))
      graph[node(include.file)].emplace(node(include.header), at(include));
  return graph;
}

// Depth first; each arrow back to a node of the current path closes a cycle.
void search(const Graph& graph, const std::string& node, std::vector<std::string>& path, Names& done,
            std::vector<std::string>& cycles) {
  const auto arrows = graph.find(node);
  path.push_back(node);
  if (arrows != graph.end())
    for (const auto& [next, include] : arrows->second) {
      const auto begin = std::ranges::find(path, next);
      if (begin == path.end()) {
        if (!done.contains(next)) search(graph, next, path, done, cycles);
        continue;
      }
      std::string names, lines;
      for (auto step = begin; step != path.end(); ++step) {
        names += *step + " -> ";
        lines += "\n    " + graph.at(*step).at(step + 1 == path.end() ? next : *(step + 1));
      }
      cycles.push_back(names + next + lines);
    }
  path.pop_back();
  done.insert(node);
}

std::vector<std::string> cycles_of(const Graph& graph) {
  std::vector<std::string> cycles, path;
  Names done;
  for (const auto& [node, arrows] : graph)
    if (!done.contains(node)) search(graph, node, path, done, cycles);
  return cycles;
}

}  // namespace

Table read_table(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("no table " + file.string());
  Table table;
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(':');
    if (line.starts_with('#') || colon == std::string::npos) continue;
    const std::string name = trimmed(line.substr(0, colon));
    std::istringstream words(line.substr(colon + 1));
    std::vector<std::string> list;
    for (std::string word; words >> word;) list.push_back(word);
    if (name.starts_with('<')) {
      table.heavy.emplace_back(name.substr(1), list);
    } else {
      table.rooms.push_back(name);
      table.allowed[name] = Names(list.begin(), list.end());
    }
  }
  return table;
}

std::vector<Include> read_includes(const fs::path& root) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::vector<Include> found;
  for (const char* folder : folders) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      const std::string file = fs::relative(entry.path(), root).string();
      if ((extension != ".hpp" && extension != ".cpp") || file.starts_with("apps/examples/")) continue;
      std::ifstream in(entry.path());
      std::string text;
      for (int line = 1; std::getline(in, text); ++line)
        if (std::smatch match; std::regex_search(text, match, pattern) && match[2] != generated)
          found.push_back({file, line, match[2], match[1] == "\""});
    }
  }
  return found;
}

std::string room_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? file : file.substr(0, slash);
}

std::string unit_of(const std::string& file) {
  return file.substr(0, file.rfind('.'));
}

std::vector<std::string> faults_of_table(const Table& table, const std::vector<Include>& includes) {
  std::vector<std::string> faults;
  Names above;
  for (const std::string& room : table.rooms) {
    for (const std::string& other : table.allowed.at(room))
      if (!above.contains(other))
        faults.push_back("rooms.txt: " + room + " names " + other + ", which does not stand above it");
    if (!above.insert(room).second) faults.push_back("rooms.txt: " + room + " stands there twice");
  }
  Names used;
  for (const Include& include : includes) used.insert(room_of(include.file));
  for (const std::string& room : used)
    if (!above.contains(room)) faults.push_back(room + " is no room of rooms.txt");
  for (const std::string& room : above)
    if (!used.contains(room)) faults.push_back("rooms.txt: " + room + " has no file");
  return faults;
}

std::vector<std::string> forbidden_includes(const Table& table, const std::vector<Include>& includes) {
  std::vector<std::string> broken;
  for (const Include& include : includes) {
    const std::string from = room_of(include.file), to = room_of(include.header);
    if (include.quoted && !is_ours(include.header))
      broken.push_back(at(include) + ", expected a path from the root");
    else if (include.quoted && from != to && table.allowed.contains(from) &&
             !table.allowed.at(from).contains(to))
      broken.push_back(at(include));
  }
  return broken;
}

std::vector<std::string> misplaced_heavy_headers(const Table& table, const std::vector<Include>& includes) {
  std::vector<std::string> broken;
  for (const Include& include : includes) {
    const bool is_private = include.header.ends_with("_cgal.hpp");  // carries CGAL along
    if (is_private && !include.file.ends_with("_cgal.hpp") &&
        (!include.file.ends_with(".cpp") || room_of(include.file) != room_of(include.header)))
      broken.push_back(at(include) + ", expected in a .cpp of " + room_of(include.header));
    for (const auto& [header, files] : table.heavy)
      if (matches(header, include.header) &&
          std::ranges::none_of(files, [&](const std::string& file) { return matches(file, include.file); }))
        broken.push_back(at(include));
  }
  return broken;
}

std::vector<std::string> room_cycles(const std::vector<Include>& includes) {
  return cycles_of(graph_of(includes, room_of));
}

std::vector<std::string> unit_cycles(const std::vector<Include>& includes) {
  return cycles_of(graph_of(includes, unit_of));
}

std::string drawing(const Table& table, const std::vector<Include>& includes) {
  const Graph graph = graph_of(includes, room_of);
  std::size_t width = 0;
  for (const std::string& room : table.rooms) width = std::max(width, room.size());
  std::string text;
  for (const std::string& room : table.rooms) {
    text += room + std::string(width - room.size(), ' ') + " ->";
    if (const auto arrows = graph.find(room); arrows != graph.end())
      for (const auto& [to, include] : arrows->second)
        text += (table.allowed.at(room).contains(to) ? " " : " !!") + to;
    text += '\n';
  }
  return text;
}

}  // namespace forefeel::house
