#pragma once
// Results that the cache folder keeps as JSON, with a checksum.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace forefeel {

// Nothing where the file is missing, incomplete or altered, or the path is empty: the result is then computed again.
std::optional<nlohmann::ordered_json> read_kept(const std::filesystem::path& file);
// Keeps nothing where the path is empty or the file cannot be written.
void keep(const std::filesystem::path& file, nlohmann::ordered_json result);

}  // namespace forefeel
