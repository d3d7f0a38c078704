#include "apps/console/json.hpp"

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/console.hpp"

namespace forefeel {

nlohmann::ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value) {
  return nlohmann::ordered_json::array({number(value.x()), number(value.y()), number(value.z())});
}

void print_json(const nlohmann::ordered_json& document) {
  flush_warnings();
  std::cout << document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n'
            << std::flush;
}

}  // namespace forefeel
