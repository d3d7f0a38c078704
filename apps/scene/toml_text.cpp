#include "apps/scene/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <fstream>

#include "geometry/common/error.hpp"
#include "geometry/common/scanner.hpp"

namespace forefeel {
namespace {

// Dots of the longest dotted name in a line without comments and quoted texts.
int dots_of_longest_name(std::string_view line) {
  int dots = 0, most = 0;
  char quote = 0;
  for (const char c : line) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '#') {
      break;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '.') {
      most = std::max(most, ++dots);
    } else if (c == ',' || c == '=' || c == '[' || c == ']' || c == '{' || c == '}') {
      dots = 0;
    }
  }
  return most;
}

}  // namespace

std::string read_toml(const std::filesystem::path& file, const std::string& what) {
  std::ifstream in(file, std::ios::binary);
  if (!in || !std::filesystem::is_regular_file(file))
    throw InputError({.file = file.string()}, fmt::format("cannot be read, expected {} (TOML)", what));
  if (std::filesystem::file_size(file) > 16'000'000)
    throw InputError({.file = file.string()}, fmt::format("is above 16 MB, expected {} (TOML)", what));
  in.close();
  return std::filesystem::file_size(file) == 0 ? std::string() : read_text_file(file);
}

toml::table parse_toml(std::string_view text, const std::filesystem::path& file) {
  check_key_depth(text, file);
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    std::string problem(error.description());
    std::ranges::replace(problem, '\n', ' ');
    throw InputError({.file = file.string(), .line = error.source().begin.line}, "not TOML: " + problem);
  }
}

void check_key_depth(std::string_view text, const std::filesystem::path& file) {
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    if (dots_of_longest_name(text.substr(0, end)) >= most_key_parts)
      throw InputError({.file = file.string(), .line = line},
                       fmt::format("a key has too many parts, expected at most {}", most_key_parts));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
}

}  // namespace forefeel
