#include "geometry/common/tolerance.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace forefeel {

std::optional<Tolerance> tolerance_from(std::string_view text) {
  Tolerance tolerance;
  if (text.ends_with("N")) {
    tolerance.newtons = true;
    text.remove_suffix(1);
  }
  while (text.ends_with(" ")) text.remove_suffix(1);
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, tolerance.value);
  if (failed != std::errc() || stopped != end || !(tolerance.value > 0) || !std::isfinite(tolerance.value))
    return {};
  return tolerance;
}

std::string in_words(const Tolerance& tolerance) {
  return tolerance.newtons ? fmt::format("{:.4g} N", tolerance.value)
                           : fmt::format("{:.4g} %", 100 * tolerance.value);
}

}  // namespace forefeel
