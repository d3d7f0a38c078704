#pragma once
// Reads the text of a TOML file and parses it. Private to the readers of scenes and studies.

#include <filesystem>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace forefeel {

// what: "a scene", for errors. InputError where the file cannot be read.
std::string read_toml(const std::filesystem::path& file, const std::string& what);
// InputError with the line if the text is not valid TOML.
toml::table parse_toml(std::string_view text, const std::filesystem::path& file);

// The parser recurses over the parts of a dotted key without a limit, so parse_toml() checks this first: InputError
// with file and line for a key or a header of a table with too many parts.
constexpr int most_key_parts = 64;
void check_key_depth(std::string_view text, const std::filesystem::path& file);

}  // namespace forefeel
