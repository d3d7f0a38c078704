#pragma once
// Colours of all pictures of this process. A palette gives the curves; the colours of labels and of everything else
// that has a meaning are derived from it.

#include <string>
#include <string_view>
#include <vector>

#include "geometry/coverage/coverage.hpp"

namespace forefeel {

using Palette = std::vector<std::string>;  // "#rrggbb", at least one

// By name: okabe-ito (default), bright, grey; or a list "#0072b2,#d55e00". InputError("--palette") for
// another text.
Palette palette_from_text(const std::string& text);
std::vector<std::string> palette_names();
inline constexpr std::string_view usual_palette = "okabe-ito";

// Called once, before the first picture; pictures of other threads read it. InputError as above.
void use_palette(const std::string& text);
const Palette& palette_in_use();

// The colour of a meaning: a label, "rendered", "body" and so on (palette.cpp lists them), in the palette in use.
// okabe-ito has colours of its own for these. Of a list, safe, sparse and gap are the first three colours, if there are
// three.
const std::string& ink(std::string_view meaning);
inline const std::string& colour(Label label) {
  return ink(name(label));
}

// From one colour "#rrggbb" to another, as share goes from 0 to 1.
std::string mixed(const std::string& from, const std::string& to, double share);

// The colour of curve i; they repeat.
inline const std::string& colour_of(const Palette& palette, std::size_t i) {
  return palette[i % palette.size()];
}
// The same in the pictures of experiments, where the palette's second colour comes first.
const std::string& line_colour(std::size_t i);

}  // namespace forefeel
