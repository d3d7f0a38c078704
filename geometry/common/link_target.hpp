#pragma once
// Symbolic links.

#include <filesystem>

namespace forefeel {

// The file that a name leads to: symbolic links followed, even to a file that is missing. A name without links
// is returned as it is. InputError: links that lead in a circle.
std::filesystem::path followed(const std::filesystem::path& file);

}  // namespace forefeel
