#pragma once
// The largest error that a force f [N] may have, relative or absolute:
//   limit(f) = value max(||f||, floor)   relative, value [1], floor [N]
//   limit(f) = value                     absolute, value [N]

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace forefeel {

struct Tolerance {
  double value = 0.07;
  bool newtons = false;
  double floor = 0.05;  // smaller forces count as this one [N]

  double limit(double force) const { return newtons ? value : value * std::max(force, floor); }  // [N]
};

// "0.07" or "0.07 N"; nullopt for any other text, and for numbers that are not above 0.
std::optional<Tolerance> tolerance_from(std::string_view text);
std::string in_words(const Tolerance& tolerance);  // "7 %", "0.07 N"

}  // namespace forefeel
