#include "geometry/common/error.hpp"

namespace forefeel {

std::string InputPlace::text() const {
  std::string text = file;
  if (line > 0) text += ":" + std::to_string(line);
  if (option.empty() && key.empty()) return text;
  if (!text.empty()) text += ": ";
  text += option;
  if (!option.empty()) text += " ";
  text += key;
  if (value) text += (option.empty() ? " " : "=") + *value;
  return text;
}

std::string InputError::one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return text;
}

}  // namespace forefeel
