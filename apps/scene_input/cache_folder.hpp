#pragma once
// Where results that are expensive to make again are kept between runs: meshes of phantoms, reference states,
// chosen spacings.

#include <filesystem>

namespace forefeel {

// $XDG_CACHE_HOME/forefeel or ~/.cache/forefeel, made if missing; empty where neither can be written.
std::filesystem::path cache_folder();

}  // namespace forefeel
