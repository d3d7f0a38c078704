#pragma once
// Bytes as text and back (RFC 4648, with padding).

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

std::string base64(std::string_view bytes);

template <class T>
std::string base64(const std::vector<T>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

// Nothing if a character does not belong there; less than a group of four at the end is left out.
std::optional<std::string> from_base64(std::string_view text);

inline std::size_t base64_length(std::size_t bytes) {
  return (bytes + 2) / 3 * 4;
}

}  // namespace forefeel
