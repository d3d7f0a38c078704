#pragma once
// Counts with their nouns, for sentences.

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

}  // namespace forefeel
