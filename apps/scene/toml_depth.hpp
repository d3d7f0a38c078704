#pragma once
// The parser of TOML recurses over the parts of a dotted key without a limit. This check comes before it.

#include <filesystem>
#include <string_view>

namespace forefeel {

constexpr int most_key_parts = 64;

// InputError with file and line for a key or a header of a table with more parts than that.
void check_key_depth(std::string_view text, const std::filesystem::path& file);

}  // namespace forefeel
