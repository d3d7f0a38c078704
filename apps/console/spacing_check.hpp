#pragma once
// Detects a spacing that is larger than the box of the states, usually because of a wrong unit.

#include <optional>
#include <string>

#include "geometry/common/types.hpp"

namespace forefeel {

// One line if spacing [m] exceeds the longest side of a box that is not a point. place: where the spacing was given,
// such as "--spacing". of: the owner of the box, such as "the states".
std::optional<std::string> spacing_beyond(const std::string& place, double spacing, const Box& box,
                                          const std::string& of);

}  // namespace forefeel
