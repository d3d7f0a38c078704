#include "geometry/common/base64.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace forefeel {

constexpr std::string_view base64_letters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve(base64_length(bytes.size()));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? base64_letters[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::optional<std::string> from_base64(std::string_view text) {
  static const auto table = [] {
    std::array<int, 256> t;
    t.fill(-1);
    for (std::size_t i = 0; i < base64_letters.size(); ++i)
      t[static_cast<unsigned char>(base64_letters[i])] = static_cast<int>(i);
    return t;
  }();
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  for (std::size_t i = 0; i + 4 <= text.size(); i += 4) {
    std::uint32_t word = 0;
    int padding = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const int value = table[static_cast<unsigned char>(text[i + k])];
      if (value < 0 && (text[i + k] != '=' || k < 2)) return {};
      padding += value < 0;
      word = word << 6 | static_cast<std::uint32_t>(std::max(value, 0));
    }
    for (int k = 0; k < 3 - padding; ++k) bytes.push_back(static_cast<char>(word >> (16 - 8 * k)));
  }
  return bytes;
}

}  // namespace forefeel
