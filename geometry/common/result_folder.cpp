#include "geometry/common/result_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr const char* marker = ".forefeel";

bool matches(const std::string& name, const std::string& pattern) {
  return pattern.starts_with('*') ? name.ends_with(pattern.substr(1)) : name == pattern;
}

bool mentions(const fs::path& file, std::initializer_list<const char*> words) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  return std::ranges::all_of(words,
                             [&](const char* word) { return text.str().find(word) != std::string::npos; });
}

bool is_of_older_version(const fs::path& folder) {
  return mentions(folder / "summary.json", {"\"provenance\"", "\"scene_hash\""}) ||
         mentions(folder / "study.json", {"\"commit\"", "\"cells\""});
}

std::set<std::string> listed_in(const fs::path& folder) {
  std::set<std::string> names;
  std::ifstream in(folder / marker);
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && !line.starts_with('#')) names.insert(line);
  return names;
}

void refuse_foreign(const fs::path& folder, const std::vector<std::string>& names,
                    const std::set<std::string>& ours) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const auto is_named = [&](const std::string& pattern) { return matches(name, pattern); };
    if (std::ranges::none_of(names, is_named) || std::ranges::any_of(ours, is_named)) continue;
    throw InputError({.file = entry.path().string()},
                     "is there already and was not made by forefeel, expected an empty folder, or one of an "
                     "earlier run; move the file away, or give another folder with -o");
  }
}

}  // namespace

void claim_folder(const fs::path& folder, const std::vector<std::string>& names) {
  if (folder.empty()) throw InputError("--output", "is empty, expected a folder for the files of the run");
  std::error_code error;
  std::set<std::string> ours;
  if (fs::is_directory(folder, error)) {
    ours = listed_in(folder);
    if (!(ours.empty() && is_of_older_version(folder))) refuse_foreign(folder, names, ours);
  }
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw InputError({.file = folder.string()}, "cannot be made, expected a folder for the files of the run");
  ours.insert(names.begin(), names.end());
  std::string list = "# Files in this folder that forefeel made, and may replace.\n";
  for (const std::string& name : ours) list += name + "\n";
  write_whole(folder / marker, list);
}

}  // namespace forefeel
