#include "apps/picture/palette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <span>
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

// A meaning and its colours: in the usual palette; in others that of a curve, or the usual one (curve: -1); in grey.
struct Ink {
  const char* meaning;
  const char* usual;
  int curve = -1;
  const char* grey = nullptr;  // null: as in other palettes
};

const Ink inks[] = {
    // Labels. Dark blue, light blue, amber, near-white: told apart with every kind of colour vision. In grey print,
    // darker means better known.
    {"safe", "#0b4f7d", 0, "#2f2f2f"},
    {"sparse", "#57a7d6", 1, "#6d6d6d"},
    {"gap", "#f2b632", 2, "#b5b5b5"},
    {"blank", "#ece9e2", -1, "#f0f0f0"},
    // Curves of a session.
    {"rendered", "#1b1b1b"},
    {"sent", "#2a9d8f", 2},
    {"limit", "#c02020", -1, "#1b1b1b"},
    {"undamped", "#d1495b", 1},
    {"reference", "#1f77b4", 0},
    {"reference_light", "#8ec3ea", 5},
    {"approximation", "#1f77b4", 0},
    {"switching", "#d1495b", 1},
    {"staleness", "#e0a021", 3},
    {"bar", "#0072b2", 0},
    // Errors on the maps of a session: within the just noticeable difference, above it, far above it.
    {"within", "#57a7d6", 5, "#b5b5b5"},
    {"above", "#e69f00", 4, "#6d6d6d"},
    {"far_above", "#c02020", 1, "#1b1b1b"},
    // Bodies and what is around them.
    {"body", "#d9a892", -1, "#c4c4c4"},
    {"outline", "#c02020", -1, "#1b1b1b"},
    {"at_rest", "#cdd4da", -1, "#d4d4d4"},
    {"moved", "#c0392b", -1, "#2f2f2f"},
    {"clamp", "#6b5b4d", -1, "#5c5c5c"},
    {"contact", "#c2185b", 1, "#1b1b1b"},
    {"group", "#5aa469", 2},
    {"path", "#c2185b", 1, "#1b1b1b"},
    {"path_light", "#d9b8c8", -1, "#c4c4c4"},
    {"force", "#d1495b", 3, "#4d4d4d"},
    {"solved", "#2a9d8f", 2},
    {"failed", "#e0371f", -1, "#1b1b1b"},
    {"blank_dot", "#9b958a", -1, "#9a9a9a"},
    {"ramp_low", "#cfe3f1", -1, "#e0e0e0"},
    {"ramp_high", "#7a1f5c", -1, "#1b1b1b"},
    {"axis_x", "#b3342d", -1, "#4d4d4d"},
    {"axis_y", "#2d7a35", -1, "#4d4d4d"},
    {"axis_z", "#2b55a5", -1, "#4d4d4d"}};

using Inks = std::map<std::string, std::string, std::less<>>;

Inks inks_of(const std::string& text, const Palette& palette) {
  Inks out;
  for (const Ink& ink : inks) {
    const bool grey = text == "grey" && ink.grey;
    const bool usual = text == usual_palette || ink.curve < 0;
    out[ink.meaning] = grey ? ink.grey : usual ? ink.usual : colour_of(palette, std::size_t(ink.curve));
  }
  if (text == "bright")
    out["sparse"] = palette[4], out["gap"] = palette[3];
  else if (palette.size() < 3)
    for (const Ink& label : std::span(inks).first(3)) out[label.meaning] = label.usual;
  return out;
}

struct InUse {
  Palette palette;
  Inks colours;
  explicit InUse(const std::string& text)
      : palette(palette_from_text(text)), colours(inks_of(text, palette)) {}
};

InUse& in_use() {
  static InUse all{std::string(usual_palette)};
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
  in_use() = InUse(text);
}

const Palette& palette_in_use() {
  return in_use().palette;
}

const std::string& ink(std::string_view meaning) {
  const auto found = in_use().colours.find(meaning);
  assert(found != in_use().colours.end());
  return found->second;
}

std::string mixed(const std::string& from, const std::string& to, double share) {
  std::string out = "#";
  for (std::size_t i = 1; i < 7; i += 2) {
    const int a = std::stoi(from.substr(i, 2), nullptr, 16), b = std::stoi(to.substr(i, 2), nullptr, 16);
    out += fmt::format("{:02x}", static_cast<int>(std::lround(a + share * (b - a))));
  }
  return out;
}

const std::string& line_colour(std::size_t i) {
  const Palette& palette = palette_in_use();
  const std::size_t k = i % palette.size();
  return colour_of(palette, k < 2 ? 1 - k : k);
}

}  // namespace forefeel
