#include "apps/scene/scene_override.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "apps/scene/scene_declared.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
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
