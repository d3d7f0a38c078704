#include "apps/scene/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "apps/scene/scene_declared.hpp"
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

namespace {

// The text after '=', read as TOML if it is one value, else as a bare string.
toml::table parse_value(const std::string& text) {
  if (text.find('\n') == std::string::npos) {
    try {
      toml::table table = toml::parse("value = " + text, std::string_view("--set"));
      if (table.size() == 1) return table;
    } catch (const toml::parse_error&) {  // a bare word
    }
  }
  return toml::table{{"value", text}};
}

void drop_alternatives(const std::string& section, const std::string& key, toml::table& table) {
  for (const SceneRowList* rows : scene_rows())
    for (const std::string& other : rows->alternatives())
      if (exclude_each_other(section + "." + key, rows->name() + "." + other)) table.erase(other);
}

// The table of a list [[key]] that an override means: the one whose group is `next`, else the one without a
// group. `named` says which. Null if there is no such table.
toml::table* table_of_list(toml::array& list, const std::string& next, bool& named) {
  toml::table* rest = nullptr;
  for (toml::node& element : list) {
    const std::optional<std::string_view> group = group_of(element);
    named = group && *group == next;
    if (named) return element.as_table();
    if (!group && !rest) rest = element.as_table();
  }
  return rest;
}

}  // namespace

// The value of the key "group" of a table in a list.
std::optional<std::string_view> group_of(const toml::node& table) {
  const toml::node* value = table.as_table() ? table.as_table()->get("group") : nullptr;
  if (!value || !value->is_string()) return {};
  return value->as_string()->get();
}

void override_key(toml::table& scene, const std::string& text, std::set<std::string>& overridden) {
  const std::size_t equals = text.find('=');
  const InputPlace where =
      equals == std::string::npos
          ? InputPlace{.option = "--set", .key = text}
          : InputPlace{.option = "--set", .key = text.substr(0, equals), .value = text.substr(equals + 1)};
  if (equals == std::string::npos || equals == 0)
    throw InputError(where, "has no value, expected key.path=value");
  const std::string path = text.substr(0, equals);
  std::vector<std::string> keys;
  std::istringstream parts(path);
  for (std::string key; std::getline(parts, key, '.');) keys.push_back(key);
  if (std::ranges::find(keys, "") != keys.end() || path.ends_with("."))
    throw InputError(where, "has an empty key, expected key.path=value");
  toml::table* table = &scene;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    if (i == 1) drop_alternatives(keys[0], keys[1], *table);
    toml::node& inner = table->emplace<toml::table>(keys[i]).first->second;
    bool named = false;
    table = inner.is_array() ? table_of_list(*inner.as_array(), keys[i + 1], named) : inner.as_table();
    if (named && ++i + 1 == keys.size())
      throw InputError(where, fmt::format("'{}' is a table of the scene, expected one of its keys", path));
    if (!table) throw InputError(where, fmt::format("'{}' is not a table of the scene", keys[i]));
  }
  if (keys.size() == 2) drop_alternatives(keys[0], keys[1], *table);
  toml::table parsed = parse_value(text.substr(equals + 1));
  table->insert_or_assign(keys.back(), std::move(*parsed.get("value")));
  overridden.insert(path);
}

}  // namespace forefeel
