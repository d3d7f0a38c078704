#pragma once
// The cache folder. It keeps results that are expensive to compute between runs: meshes of phantoms,
// reference states, chosen spacings, discretisation errors.

#include <cstddef>
#include <cstdint>
#include <filesystem>

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

}  // namespace forefeel
