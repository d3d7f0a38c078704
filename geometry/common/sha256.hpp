#pragma once
// SHA-256 (FIPS 180-4): the hash behind the identity of bodies and scenes and the names of cache files.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace forefeel {

class Sha256 {
 public:
  Sha256& add(const void* data, std::size_t bytes);
  Sha256& add(std::string_view text) { return add(text.data(), text.size()); }
  Sha256& add(double value);        // its IEEE bits, little endian, -0 as 0
  Sha256& add(std::int64_t value);  // little endian
  std::string hex() const;          // 64 digits, of the data added so far; more data may be added

 private:
  void block(const std::uint8_t* data);

  std::array<std::uint32_t, 8> hash_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                     0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> pending_{};
  std::uint64_t length_ = 0;  // bytes so far
};

}  // namespace forefeel
