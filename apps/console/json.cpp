#include "apps/console/json.hpp"

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"
#include "geometry/common/sha256.hpp"

namespace forefeel {

nlohmann::ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value) {
  return nlohmann::ordered_json::array({number(value.x()), number(value.y()), number(value.z())});
}

std::string sum_of(const nlohmann::ordered_json& value) {
  return Sha256().add(json_text(value)).hex();
}

std::string json_text(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void print_json(const nlohmann::ordered_json& document) {
  flush_warnings();
  print(std::cout, json_text(document, 2));
}

}  // namespace forefeel
