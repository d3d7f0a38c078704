#pragma once
// The tables of a touch session: frames.csv and dispatch.csv. Positions are in the axes of the mesh.

#include <filesystem>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/touch/touch_result.hpp"

namespace forefeel {

// Throws InputError for a table that cannot be written.
void write_touch_files(const std::filesystem::path& folder, const TouchSessionResult& result, bool real);
std::vector<DeclaredTable> declared_touch_files();

}  // namespace forefeel
