#pragma once
// Counts with their nouns, and shares, for sentences.

#include <fmt/format.h>

#include <cmath>
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

// A share in a summary: "0 %", "below 0.1 %", "6.4 %", "above 99.9 %", "100 %". Only what is exactly so is called none
// or all.
inline std::string said_percent(double share) {
  const double value = 100 * share;
  if (value == 0 || value == 100) return fmt::format("{:.0f} %", value);
  if (value > 0 && value < 0.1) return "below 0.1 %";
  if (value > 99.9 && value < 100) return "above 99.9 %";
  return fmt::format("{:.1f} %", value);
}

// "0.031 J"; "0 J" for what is no more than rounding.
inline std::string said_joules(double energy) {
  return std::abs(energy) < 1e-9 ? "0 J" : fmt::format("{:.3g} J", energy);
}

}  // namespace forefeel
