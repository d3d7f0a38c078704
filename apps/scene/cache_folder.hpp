#pragma once
// The cache folder. It keeps results that are expensive to compute between runs: meshes of phantoms,
// reference states, chosen spacings, discretisation errors.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace forefeel {

// $XDG_CACHE_HOME/forefeel or ~/.cache/forefeel, created if missing. Empty if neither can be written.
std::filesystem::path cache_folder();

struct CacheContent {
  std::size_t files = 0;  // of the cache
  std::uintmax_t bytes = 0;
  std::size_t in_use = 0;   // state files that another process writes, with their logs
  std::size_t foreign = 0;  // files that the cache did not make
};
CacheContent cache_content(const std::filesystem::path& folder);
// Removes the files of the cache but for those in use. Counts what was removed, and what was in use.
CacheContent empty_cache(const std::filesystem::path& folder);

// A result that the cache folder keeps as JSON, with a checksum. Nothing where the file is missing, incomplete or
// altered, or the path is empty: the result is then computed again.
std::optional<nlohmann::ordered_json> read_kept(const std::filesystem::path& file);
// Keeps nothing where the path is empty or the file cannot be written.
void keep(const std::filesystem::path& file, nlohmann::ordered_json result);

}  // namespace forefeel
