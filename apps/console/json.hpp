#pragma once
// Values and documents of --json.

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

namespace forefeel {

nlohmann::ordered_json number(double value);  // null if not finite
nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value);
void print_json(const nlohmann::ordered_json& document);  // to stdout, after the warnings held back

}  // namespace forefeel
