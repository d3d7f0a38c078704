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

// Dark blue, light blue, amber, near-white: told apart with every kind of colour vision. In grey print, darker means
// better known.
const PictureColours usual_colours{.labels = {"#0b4f7d", "#57a7d6", "#f2b632", "#ece9e2"},
                                   .rendered = "#1b1b1b",
                                   .sent = "#2a9d8f",
                                   .limit = "#c02020",
                                   .undamped = "#d1495b",
                                   .reference = "#1f77b4",
                                   .reference_light = "#8ec3ea",
                                   .approximation = "#1f77b4",
                                   .switching = "#d1495b",
                                   .staleness = "#e0a021"};

PictureColours colours_of(const std::string& text, const Palette& palette) {
  if (text == usual_palette) return usual_colours;
  PictureColours out = usual_colours;
  if (text == "grey")
    out.labels = {"#2f2f2f", "#6d6d6d", "#b5b5b5", "#f0f0f0"};
  else if (text == "bright")
    out.labels = {"#4477aa", "#66ccee", "#ccbb44", "#ece9e2"};
  else if (palette.size() >= 3)
    out.labels = {palette[0], palette[1], palette[2], out.labels[3]};
  out.reference = out.approximation = colour_of(palette, 0);
  out.undamped = out.switching = colour_of(palette, 1);
  out.sent = colour_of(palette, 2);
  out.staleness = colour_of(palette, 3);
  out.reference_light = colour_of(palette, 5);
  if (text == "grey") out.limit = out.rendered;
  return out;
}

struct InUse {
  Palette palette = palette_from_text(std::string(usual_palette));
  PictureColours colours = usual_colours;
};

InUse& in_use() {
  static InUse all;
  return all;
}

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

void use_palette(const std::string& text) {
  const Palette palette = palette_from_text(text);
  in_use() = {palette, colours_of(text, palette)};
}

const Palette& palette_in_use() {
  return in_use().palette;
}

const PictureColours& colours_in_use() {
  return in_use().colours;
}

}  // namespace forefeel
