#pragma once
// Overrides of a parsed scene: "key.path=value" as given to --set. Private to this room.

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace forefeel {

// Sets the key and adds its path to `overridden`. value is TOML, or a bare string; keys that exclude this one are
// dropped. Of a list of tables [[key]], "key.NAME.…" means the one with group = "NAME", "key.…" the one without a
// group. Throws InputError if the text lacks key or value.
void override_key(toml::table& scene, const std::string& text, std::set<std::string>& overridden);

// Of a table of a list: what its key "group" says.
std::optional<std::string_view> group_of(const toml::node& table);

}  // namespace forefeel
