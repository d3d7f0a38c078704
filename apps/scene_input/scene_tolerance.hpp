#pragma once
// state_space.tolerance of a scene: a share of the force (0.07), or newtons ("0.07 N").

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "geometry/common/tolerance.hpp"

namespace forefeel {

class SceneTable;

// Of the table [state_space]; nothing where it has none. InputError for what is no tolerance above 0.
std::optional<Tolerance> read_tolerance(const SceneTable& state_space);
// Of the scene in a file, as overridden. Reads nothing else of it.
std::optional<Tolerance> written_tolerance(const std::filesystem::path& file,
                                           std::span<const std::string> overrides);

}  // namespace forefeel
