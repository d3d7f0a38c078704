#pragma once
// Reads state_space.tolerance of a scene: a share of the force (0.07) or a force in newtons ("0.07 N").

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "geometry/common/tolerance.hpp"

namespace forefeel {

class SceneTable;

// From the table [state_space]; nullopt if the key is missing. InputError for a value that is not a tolerance above 0.
std::optional<Tolerance> read_tolerance(const SceneTable& state_space);
// From a scene file with its overrides. Reads no other key.
std::optional<Tolerance> written_tolerance(const std::filesystem::path& file,
                                           std::span<const std::string> overrides);

}  // namespace forefeel
