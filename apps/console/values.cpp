#include "apps/console/values.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

// NaN: not a finite number.
double number_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value) ? value : std::nan("");
}

}  // namespace

std::string above_zero(const std::string& text) {
  return number_of(text) > 0 ? "" : fmt::format("is {}, expected a number above 0", text);
}

std::string zero_or_more(const std::string& text) {
  return number_of(text) >= 0 ? "" : fmt::format("is {}, expected 0 or a number above it", text);
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
