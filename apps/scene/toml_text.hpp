#pragma once
// Reads the text of a TOML file and parses it. Private to the readers of scenes and studies.

#include <toml++/toml.h>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace forefeel {

// what: "a scene", for errors. InputError where the file cannot be read.
std::string read_toml(const std::filesystem::path& file, const std::string& what);
// InputError with the line if the text is not valid TOML.
toml::table parse_toml(std::string_view text, const std::filesystem::path& file);

// The parser recurses over the parts of a dotted key without a limit, so parse_toml() checks this first: InputError
// with file and line for a key or a header of a table with too many parts.
constexpr int most_key_parts = 64;
void check_key_depth(std::string_view text, const std::filesystem::path& file);

// Overrides of a parsed scene: "key.path=value" as given to --set.

// Sets the key and adds its path to `overridden`. The value is TOML or a bare string; keys that exclude this one are
// removed. In a list of tables [[key]], "key.NAME.…" means the table with group = "NAME", and "key.…" the table without
// a group. Throws InputError if the text lacks key or value.
void override_key(toml::table& scene, const std::string& text, std::set<std::string>& overridden);

// The value of the key "group" of a table in a list.
std::optional<std::string_view> group_of(const toml::node& table);

}  // namespace forefeel
