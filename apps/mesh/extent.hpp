#pragma once
// Where a body lies, as JSON and in words.

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "geometry/common/types.hpp"

namespace forefeel {

nlohmann::ordered_json box_json(const Box& box);  // [[x0, y0, z0], [x1, y1, z1]], in m
std::string size_text(const Vec3& size);          // "0.1 x 0.04 x 0.04 m"
std::string box_text(const Box& box);             // "x 0 to 0.1, y -0.02 to 0.02, z 0 to 0.04 m"

}  // namespace forefeel
