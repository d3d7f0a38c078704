#pragma once
// Overrides of a parsed scene: "key.path=value" as given to --set. Private to this room.

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace forefeel {

// Sets the key and adds its path to `overridden`. The value is TOML or a bare string; keys that exclude this one are
// removed. In a list of tables [[key]], "key.NAME.…" means the table with group = "NAME", and "key.…" the table without
// a group. Throws InputError if the text lacks key or value.
void override_key(toml::table& scene, const std::string& text, std::set<std::string>& overridden);

// The value of the key "group" of a table in a list.
std::optional<std::string_view> group_of(const toml::node& table);

}  // namespace forefeel
