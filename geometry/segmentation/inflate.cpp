#include "geometry/segmentation/inflate.hpp"

#include <algorithm>
#include <array>

#ifdef FOREFEEL_ZLIB
#include <zlib.h>
#endif

#include "geometry/common/error.hpp"

namespace forefeel {

bool is_compressed(std::string_view data) {
  return data.size() > 2 && data[0] == '\x1f' && data[1] == '\x8b';
}

#ifdef FOREFEEL_ZLIB

namespace {

struct Stream {
  z_stream z{};
  bool good = false;
  Stream() { good = inflateInit2(&z, 15 + 32) == Z_OK; }  // 32: gzip or zlib, by the header
  ~Stream() { inflateEnd(&z); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
};

}  // namespace

std::string inflate(std::string_view data, std::size_t bytes, const std::string& file) {
  Stream stream;
  std::string result;
  std::array<char, 1 << 16> part;
  std::size_t given = 0;
  while (stream.good && result.size() < bytes) {
    if (stream.z.avail_in == 0 && given < data.size()) {
      const std::size_t more = std::min<std::size_t>(data.size() - given, 1u << 30);
      stream.z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data() + given));
      stream.z.avail_in = static_cast<uInt>(more);
      given += more;
    }
    stream.z.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.z.avail_out = static_cast<uInt>(part.size());
    const int code = ::inflate(&stream.z, Z_NO_FLUSH);
    const std::size_t made = part.size() - stream.z.avail_out;
    result.append(part.data(), std::min(made, bytes - result.size()));
    if (code == Z_STREAM_END || (code == Z_BUF_ERROR && made == 0)) break;  // its end, or cut short
    if (code != Z_OK && code != Z_BUF_ERROR) throw InputError({.file = file}, "compressed data are damaged");
  }
  return result;
}

#else

std::string inflate(std::string_view, std::size_t, const std::string& file) {
  throw InputError({.file = file}, "its data are compressed, expected plain data (this build has no zlib)");
}

#endif

}  // namespace forefeel
