#pragma once
// Limits the number of parts of a dotted key, before the TOML parser reads it: the parser recurses over these parts
// without a limit.

#include <filesystem>
#include <string_view>

namespace forefeel {

constexpr int most_key_parts = 64;

// InputError with file and line for a key or a header of a table with more parts than that.
void check_key_depth(std::string_view text, const std::filesystem::path& file);

}  // namespace forefeel
