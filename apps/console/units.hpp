#pragma once
// Lengths [m] and volumes [m^3] in the units of what is said: those of a hand, or those of a landscape.

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "geometry/common/types.hpp"

namespace forefeel {

// mm and cm3; m and m3 for points at least 0.1 m from each other.
class Units {
 public:
  explicit Units(double spacing) : large_(spacing >= 0.1) {}
  double length(double metres) const { return large_ ? metres : 1e3 * metres; }
  std::string place(const Vec3& at) const {
    return fmt::format("{:.4g}, {:.4g}, {:.4g} {}", length(at.x()), length(at.y()), length(at.z()),
                       of_length());
  }
  std::string distance(double metres) const {
    return std::isnan(metres) ? "-" : fmt::format("{:.4g} {}", length(metres), of_length());
  }
  double volume(double cubic_metres) const { return large_ ? cubic_metres : 1e6 * cubic_metres; }
  const char* of_length() const { return large_ ? "m" : "mm"; }
  const char* of_volume() const { return large_ ? "m3" : "cm3"; }

 private:
  bool large_;
};

// "96.6 ms", "12 us", "850 ns"
inline std::string short_time(double seconds) {
  return seconds >= 1e-3   ? fmt::format("{:.3g} ms", 1e3 * seconds)
         : seconds >= 1e-6 ? fmt::format("{:.3g} us", 1e6 * seconds)
                           : fmt::format("{:.0f} ns", 1e9 * seconds);
}

}  // namespace forefeel
