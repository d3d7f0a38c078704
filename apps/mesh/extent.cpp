#include "apps/mesh/extent.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/console/json.hpp"

namespace forefeel {

nlohmann::ordered_json box_json(const Box& box) {
  return nlohmann::ordered_json::array({vector3(box.low), vector3(box.high)});
}

std::string size_text(const Vec3& size) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x(), size.y(), size.z());
}

std::string box_text(const Box& box) {
  return fmt::format("x {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g} m", box.low.x(),
                     box.high.x(), box.low.y(), box.high.y(), box.low.z(), box.high.z());
}

}  // namespace forefeel
