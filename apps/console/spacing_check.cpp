#include "apps/console/spacing_check.hpp"

#include <fmt/format.h>

namespace forefeel {

std::optional<std::string> spacing_beyond(const std::string& place, double spacing, const Box& box,
                                          const std::string& of) {
  const Vec3 size = box.size();
  if (!(size.maxCoeff() > 0) || !(spacing > size.maxCoeff())) return {};
  return fmt::format(
      "{}: is {:g} m, larger than the box of {} ({:.3g} x {:.3g} x {:.3g} m): labels cannot tell well known "
      "places from "
      "others; expected metres",
      place, spacing, of, size.x(), size.y(), size.z());
}

}  // namespace forefeel
