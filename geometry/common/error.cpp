#include "geometry/common/error.hpp"

#include <algorithm>

namespace forefeel {
namespace {

constexpr std::size_t longest_quote = 80, longest_path = 400, longest_problem = 1200;

// Shortens a text to at most `most` bytes: the middle is replaced by "…". Multi-byte characters stay whole.
std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto inside = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80; };
  std::size_t head = 2 * most / 3, tail = text.size() - most / 4;
  while (head > 0 && inside(head)) --head;
  while (tail < text.size() && inside(tail)) ++tail;
  return text.substr(0, head) + "…" + text.substr(tail);
}

// The end of a piece that begins at `begin`: a text in single quotes, or a word.
std::size_t end_of_piece(const std::string& text, std::size_t begin) {
  const bool word_before = begin > 0 && text[begin - 1] != ' ' && text[begin - 1] != '(';
  if (text[begin] == '\'' && !word_before) {
    for (std::size_t end = text.find('\'', begin + 1); end != std::string::npos;
         end = text.find('\'', end + 1))
      if (end + 1 == text.size() || std::string(" ,.;:)").find(text[end + 1]) != std::string::npos)
        return end + 1;
  }
  return std::min(text.find(' ', begin), text.size());
}

// Shortens long words and quoted texts in the middle, then the whole text if it is still too long.
std::string with_short_quotes(const std::string& text) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    if (text[begin] == ' ') {
      result += text[begin++];
      continue;
    }
    const std::size_t end = end_of_piece(text, begin);
    const std::string piece = text.substr(begin, end - begin);
    result += shortened(piece, piece.find('/') == std::string::npos ? longest_quote : longest_path);
    begin = end;
  }
  return shortened(result, longest_problem);
}

}  // namespace

std::string InputPlace::text() const {
  std::string text = shortened(file, longest_path);
  if (line > 0) text += ":" + std::to_string(line);
  if (option.empty() && key.empty()) return text;
  if (!text.empty()) text += ": ";
  text += option;
  if (!option.empty()) text += " ";
  text += shortened(key, longest_path);
  if (value) text += (option.empty() ? " " : "=") + shortened(*value, longest_quote);
  return text;
}

std::string InputError::one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return with_short_quotes(text);
}

}  // namespace forefeel
