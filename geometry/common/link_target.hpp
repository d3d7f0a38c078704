#pragma once
// Symbolic links.

#include <filesystem>

namespace forefeel {

// Returns the file that a name leads to after all symbolic links are followed; that file may be missing. A
// name without links is returned unchanged. InputError if the links form a circle.
std::filesystem::path followed(const std::filesystem::path& file);

}  // namespace forefeel
