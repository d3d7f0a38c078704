#pragma once
// Compressed data of images: gzip or zlib streams. Private to this room.

#include <string>
#include <string_view>

namespace forefeel {

bool is_compressed(std::string_view data);  // begins as gzip does
// The first `bytes` of the content, or fewer where the stream is shorter. InputError, with the name of the file, if the
// stream is damaged or if this build has no zlib. Takes memory only as content appears.
std::string inflate(std::string_view data, std::size_t bytes, const std::string& file);

}  // namespace forefeel
