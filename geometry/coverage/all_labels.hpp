#pragma once
// The four labels in their order.

#include <array>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

inline constexpr std::array all_labels{Label::safe, Label::sparse, Label::gap, Label::blank};

}  // namespace forefeel
