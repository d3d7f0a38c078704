#include "geometry/common/utf8.hpp"

#include <cstddef>

namespace forefeel {
namespace {

unsigned byte_of(std::string_view text, std::size_t at) {
  return at < text.size() ? static_cast<unsigned char>(text[at]) : 0;
}

// Bytes of the character that begins at `at`; 0: there is none that XML may hold.
std::size_t length_of(std::string_view text, std::size_t at) {
  const unsigned first = byte_of(text, at), second = byte_of(text, at + 1);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  if (first < 0xc2 || first > 0xf4) return 0;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte_of(text, at + i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool surrogate = first == 0xed && second > 0x9f, too_large = first == 0xf4 && second > 0x8f;
  const bool no_character = first == 0xef && second == 0xbf && byte_of(text, at + 2) >= 0xbe;
  return overlong || surrogate || too_large || no_character ? 0 : length;
}

}  // namespace

std::string valid_utf8(std::string_view text) {
  std::string valid;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = length_of(text, at);
    valid += length > 0 ? text.substr(at, length) : "\xef\xbf\xbd";
    at += length > 0 ? length : 1;
  }
  return valid;
}

std::string printable(std::string_view text) {
  std::string shown;
  const std::string valid = valid_utf8(text);
  for (std::size_t at = 0; at < valid.size(); ++at) {
    const bool c1 = byte_of(valid, at) == 0xc2 && byte_of(valid, at + 1) < 0xa0;
    if (c1) ++at;
    if (c1 || valid[at] == '\r' || valid[at] == '\x7f')
      shown += "\xef\xbf\xbd";
    else
      shown += valid[at];
  }
  return shown;
}

std::string html_escaped(std::string_view text) {
  std::string safe;
  for (const char c : valid_utf8(text))
    safe += c == '&'   ? "&amp;"
            : c == '<' ? "&lt;"
            : c == '>' ? "&gt;"
            : c == '"' ? "&quot;"
                       : std::string(1, c);
  return safe;
}

}  // namespace forefeel
