#pragma once
// Colours of all pictures of this process. A palette gives the curves; labels and the curves of a session's report are
// derived from it.

#include <array>
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

// Called once, before the first picture; pictures of other threads read it. InputError as above.
void use_palette(const std::string& text);
const Palette& palette_in_use();

struct PictureColours {
  std::array<std::string, 4> labels;  // safe, sparse, gap, blank
  // Curves by meaning.
  std::string rendered, sent, limit, undamped, reference, reference_light, approximation, switching,
      staleness;
};
// okabe-ito has colours of its own for these. Of a list, safe, sparse and gap are the first three colours, if there are
// three.
const PictureColours& colours_in_use();

// The colour of curve i; they repeat.
inline const std::string& colour_of(const Palette& palette, std::size_t i) {
  return palette[i % palette.size()];
}

}  // namespace forefeel
