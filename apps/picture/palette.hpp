#pragma once
// Colours of the curves of a study's figures.

#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

using Palette = std::vector<std::string>;  // "#rrggbb", at least one

// By name: okabe-ito (default), bright, grey; or a list "#0072b2,#d55e00". InputError("--palette") for
// another text.
Palette palette_from_text(const std::string& text);
std::vector<std::string> palette_names();
inline constexpr std::string_view usual_palette = "okabe-ito";

// The colour of curve i; they repeat.
inline const std::string& colour_of(const Palette& palette, std::size_t i) {
  return palette[i % palette.size()];
}

}  // namespace forefeel
