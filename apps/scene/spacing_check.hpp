#pragma once
// A spacing that is larger than the box of the states, usually because of another unit.

#include <optional>
#include <string>

#include "geometry/common/types.hpp"

namespace forefeel {

// One line if spacing [m] exceeds the longest side of a box that is not a point. place: where the spacing stands, as
// "--spacing". of: what the box is of, as "the states".
std::optional<std::string> spacing_beyond(const std::string& place, double spacing, const Box& box,
                                          const std::string& of);

}  // namespace forefeel
