#include "apps/picture/palette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

// okabe-ito: told apart with every kind of colour vision (Okabe, Ito 2008, without yellow); bright: Paul
// Tol's.
const std::pair<const char*, const char*> named[] = {
    {"okabe-ito", "#0072b2,#d55e00,#009e73,#cc79a7,#e69f00,#56b4e9,#1b1b1b,#8a8a8a"},
    {"bright", "#4477aa,#ee6677,#228833,#ccbb44,#66ccee,#aa3377,#bbbbbb"},
    {"grey", "#1b1b1b,#8a8a8a,#4d4d4d,#b5b5b5,#2f2f2f,#9c9c9c"}};

bool is_colour(const std::string& text) {
  return text.size() == 7 && text[0] == '#' &&
         text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
}

}  // namespace

std::vector<std::string> palette_names() {
  std::vector<std::string> names;
  for (const auto& entry : named) names.emplace_back(entry.first);
  return names;
}

Palette palette_from_text(const std::string& text) {
  std::string list = text;
  for (const auto& [name, colours] : named)
    if (text == name) list = colours;
  Palette palette;
  std::istringstream parts(list);
  for (std::string part; std::getline(parts, part, ',');) palette.push_back(part);
  if (palette.empty() || !std::ranges::all_of(palette, is_colour))
    throw InputError("--palette", fmt::format("is '{}', expected {}, or colours as #0072b2,#d55e00", text,
                                              fmt::join(palette_names(), ", ")));
  return palette;
}

}  // namespace forefeel
