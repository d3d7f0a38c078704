#include "apps/console/values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "geometry/common/error.hpp"

namespace forefeel {
std::string above_zero(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (!text.empty() && *end == '\0' && std::isfinite(value) && value > 0) return "";
  return fmt::format("is {}, expected a number above 0", text);
}

Eigen::Vector3d parse_vector(const std::string& text, const std::string& where) {
  const auto refuse = [&]() -> InputError {
    return {where, fmt::format("'{}' is not a position, expected three finite numbers X,Y,Z", text)};
  };
  Eigen::Vector3d value;
  const char* next = text.data();
  const char* const end = text.data() + text.size();
  const auto skip_blanks = [&] {
    while (next != end && *next == ' ') ++next;
  };
  for (int i = 0; i < 3; ++i) {
    skip_blanks();
    const auto [after, error] = std::from_chars(next, end, value[i]);
    if (error != std::errc{} || !std::isfinite(value[i])) throw refuse();
    next = after;
    skip_blanks();
    if (i < 2 && (next == end || *next++ != ',')) throw refuse();
  }
  if (next != end) throw refuse();
  return value;
}

}  // namespace forefeel
