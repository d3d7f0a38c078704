#pragma once
// The cache folder. It keeps results that are expensive to compute between runs: meshes of phantoms,
// reference states, chosen spacings.

#include <filesystem>

namespace forefeel {

// $XDG_CACHE_HOME/forefeel or ~/.cache/forefeel, created if missing. Empty if neither can be written.
std::filesystem::path cache_folder();

}  // namespace forefeel
