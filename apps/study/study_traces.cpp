#include "apps/study/study_traces.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "geometry/common/counted.hpp"

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view trace_prefix = "trace:";
constexpr std::array<std::string_view, 3> halves{"all", "tuning", "table"};

// A text that a pattern matches literally.
std::string literal(const std::string& text) {
  std::string pattern;
  for (const char c : text) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

// Relative to the folder, as the pattern is; sorted.
std::vector<fs::path> files_like(const fs::path& folder, const std::string& pattern) {
  const bool absolute = fs::path(pattern).is_absolute();
  const fs::path base = fs::absolute(folder.empty() ? fs::path(".") : folder);
  const std::string whole = absolute ? pattern : literal(base.string()) + "/" + pattern;
  glob_t found{};
  std::vector<fs::path> files;
  if (glob(whole.c_str(), GLOB_NOSORT, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i)
      if (const fs::path file = found.gl_pathv[i]; fs::is_regular_file(file))
        files.push_back(absolute ? file : fs::proximate(file, base));
  globfree(&found);
  std::ranges::sort(files);
  return files;
}

}  // namespace

TraceHalf study_traces(const toml::node* node, const InputPlace& place) {
  if (!node) return TraceHalf::all;
  const auto found = std::ranges::find(halves, node->value_or(std::string()));
  if (found == halves.end())
    throw InputError(
        place, fmt::format("is {}, expected all, tuning or table, in quotes", study_toml::toml_of(*node)));
  return static_cast<TraceHalf>(found - halves.begin());
}

bool is_trace_pattern(const toml::node& node) {
  const std::string text = node.value_or(std::string());
  return text.starts_with(trace_prefix) && text.substr(0, text.find(',')).find_first_of("*?") != text.npos;
}

std::vector<std::pair<std::string, std::string>> matching_traces(const std::string& pattern, TraceHalf half,
                                                                 const fs::path& study, const fs::path& scene,
                                                                 const InputPlace& place) {
  const std::size_t end = std::min(pattern.find(','), pattern.size());
  const std::string file = pattern.substr(trace_prefix.size(), end - trace_prefix.size());
  const std::string settings = pattern.substr(end);
  std::vector<fs::path> files = files_like(study.parent_path(), file);
  if (files.empty()) files = files_like(scene.parent_path(), file);
  if (files.empty())
    throw InputError(place,
                     fmt::format("no file matches '{}', expected recordings, relative to the study", file));
  std::vector<std::pair<std::string, std::string>> devices;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (half != TraceHalf::all && (i % 2 == 0) != (half == TraceHalf::tuning)) continue;
    devices.emplace_back(files[i].stem().string() + settings,
                         fmt::format("{}{}{}", trace_prefix, files[i].string(), settings));
  }
  if (devices.empty())
    throw InputError(place, fmt::format("'{}' matches {}, none of it for the table; expected at least two",
                                        file, counted(files.size(), "file")));
  return devices;
}

}  // namespace forefeel
