#pragma once
// Counts with their nouns, and shares, for sentences.

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace forefeel {

// "1 frame", "3 frames". several: the plural of a noun that needs more than an s, or "states were" of "state was".
inline std::string counted(std::size_t n, std::string_view one, std::string_view several = {}) {
  std::string text = std::to_string(n) + ' ';
  if (n == 1) return text.append(one);
  return several.empty() ? text.append(one) + 's' : text.append(several);
}

// "0.31 %", "12 %", "100 %": two digits, and all of those before the point.
inline std::string in_percent(double share) {
  return 100 * share >= 99.5 && share < 1e4 ? fmt::format("{:.0f} %", 100 * share)
                                            : fmt::format("{:.2g} %", 100 * share);
}

}  // namespace forefeel
