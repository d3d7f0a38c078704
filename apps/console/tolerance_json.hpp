#pragma once
// Prints the share of the time for which a session knew the force within the tolerance of its scene.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "geometry/common/declared.hpp"
#include "scheduling/record/tolerance_share.hpp"

namespace forefeel {

nlohmann::ordered_json to_json(const ToleranceShare& share, const Tolerance& tolerance);
std::string tolerance_in_words(const ToleranceShare& share, const Tolerance& tolerance);
std::vector<Declared> declared_tolerance();  // its keys in summary.json

}  // namespace forefeel
