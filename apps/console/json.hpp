#pragma once
// Values and documents of --json.

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace forefeel {

nlohmann::ordered_json number(double value);  // null if not finite
nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value);
nlohmann::ordered_json quantiles_json(const std::vector<double>& values);  // p50, p95 and max
void print_json(const nlohmann::ordered_json& document);  // to stdout, after the warnings held back

}  // namespace forefeel
