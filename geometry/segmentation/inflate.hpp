#pragma once
// Decompresses the data of images: gzip or zlib streams. Private to this room.

#include <string>
#include <string_view>

namespace forefeel {

bool is_compressed(std::string_view data);  // begins with the two bytes that mark gzip
// Returns the first `bytes` of the content, or fewer if the stream is shorter. InputError, with the name of the file,
// if the stream is damaged or if this build has no zlib. Memory grows with the decompressed content, not with `bytes`.
std::string inflate(std::string_view data, std::size_t bytes, const std::string& file);

}  // namespace forefeel
