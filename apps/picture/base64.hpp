#pragma once
// Bytes as text for a page's script (RFC 4648, with padding).

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace forefeel {

std::string base64(std::span<const std::byte> bytes);

template <class T>
std::string base64(const std::vector<T>& values) {
  return base64(std::as_bytes(std::span(values)));
}

}  // namespace forefeel
