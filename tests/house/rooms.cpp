#include "tests/house/rooms.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <utility>

namespace forefeel::house {
namespace {

namespace fs = std::filesystem;

bool in_a_room(const std::string& file) {
  return !file.starts_with("tests/") && !file.starts_with("apps/examples/") &&
         room_of(file).find('/') != std::string::npos;
}

std::string last_part(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

std::string listed(const Names& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<std::string> shared(const std::map<std::string, Names>& users) {
  std::vector<std::string> faults;
  for (const auto& [name, those] : users)
    if (those.size() > 1) faults.push_back("one name, " + last_part(name) + ": " + listed(those));
  return faults;
}

// A line that is a comment alone, with more characters (of UTF-8) than a comment may have.
bool is_wide_comment(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(' ');
  const auto characters = std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; });
  return begin != std::string::npos && line.compare(begin, 2, "//") == 0 && characters > most_columns;
}

}  // namespace

std::vector<SourceFile> read_files(const fs::path& root) {
  std::vector<SourceFile> files;
  for (const char* folder : {"geometry", "solver", "approx", "scheduling", "apps", "tests"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() != ".hpp" && entry.path().extension() != ".cpp") continue;
      SourceFile file{fs::relative(entry.path(), root).string(), 0};
      std::ifstream in(entry.path());
      for (std::string line; std::getline(in, line);) {
        ++file.lines;
        if (is_wide_comment(line)) file.wide_comments.push_back(file.lines);
      }
      files.push_back(std::move(file));
    }
  }
  std::ranges::sort(files, {}, &SourceFile::name);
  return files;
}

std::vector<std::string> faults_of_size(const std::vector<SourceFile>& files) {
  std::map<std::string, Names> subjects;
  for (const SourceFile& file : files)
    if (in_a_room(file.name)) subjects[room_of(file.name)].insert(unit_of(file.name));
  std::vector<std::string> faults;
  for (const auto& [room, its] : subjects)
    if (its.size() < least_subjects || its.size() > most_subjects)
      faults.push_back(room + " holds " + std::to_string(its.size()) + " subjects, expected " +
                       std::to_string(least_subjects) + " to " + std::to_string(most_subjects));
  return faults;
}

std::vector<std::string> names_used_twice(const std::vector<SourceFile>& files) {
  std::map<std::string, Names> rooms, names;
  for (const SourceFile& file : files) {
    const std::string room = room_of(file.name), name = last_part(file.name);
    if (in_a_room(file.name)) rooms[room.substr(0, room.find('/') + 1) + last_part(room)].insert(room);
    if (name != "main.cpp") names[name].insert(file.name);
  }
  std::vector<std::string> faults = shared(rooms);
  for (std::string& fault : shared(names)) faults.push_back(std::move(fault));
  return faults;
}

std::vector<std::string> long_files(const std::vector<SourceFile>& files) {
  std::vector<std::string> faults;
  for (const SourceFile& file : files)
    if (!file.name.starts_with("tests/") && file.lines > most_lines)
      faults.push_back(file.name + " has " + std::to_string(file.lines) + " lines, expected at most " +
                       std::to_string(most_lines));
  return faults;
}

std::vector<std::string> wide_comments(const std::vector<SourceFile>& files) {
  std::vector<std::string> faults;
  for (const SourceFile& file : files)
    for (const std::size_t line : file.wide_comments)
      faults.push_back(file.name + ":" + std::to_string(line) + " has a comment of more than " +
                       std::to_string(most_columns) + " columns");
  return faults;
}

std::vector<std::string> too_many_rooms_or_arrows(const std::vector<Include>& includes) {
  Names rooms;
  std::set<std::pair<std::string, std::string>> arrows;
  for (const Include& include : includes) {
    const std::string from = room_of(include.file), to = room_of(include.header);
    if (from == "apps/bench") continue;  // a program beside the product
    rooms.insert(from);
    if (include.quoted && from != to) arrows.emplace(from, to);
  }
  std::vector<std::string> faults;
  const auto count = [&](std::size_t n, std::size_t most, const std::string& what) {
    if (n > most)
      faults.push_back(std::to_string(n) + " " + what + ", expected at most " + std::to_string(most));
  };
  count(rooms.size(), most_rooms, "rooms");
  count(arrows.size(), most_arrows, "arrows");
  return faults;
}

}  // namespace forefeel::house
