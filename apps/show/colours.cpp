#include "apps/show/colours.hpp"

#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel {

std::string region_colour(std::size_t i) {
  return colour_of(palette_in_use(), i);
}

const std::string& ink(std::string_view meaning) {
  return show_colours().at(std::string(meaning));
}

const std::map<std::string, std::string>& show_colours() {
  static const std::map<std::string, std::string> all = [] {
    std::map<std::string, std::string> colours{
        {"body", "#d9a892"},      {"clamp", "#6b5b4d"},    {"contact", "#c2185b"},  {"group", "#5aa469"},
        {"path", "#c2185b"},      {"force", "#d1495b"},    {"solved", "#2a9d8f"},   {"failed", "#e0371f"},
        {"blank_dot", "#9b958a"}, {"ramp_low", "#cfe3f1"}, {"ramp_high", "#7a1f5c"}};
    for (const Label label : {Label::safe, Label::sparse, Label::gap, Label::blank})
      colours[std::string(name(label))] = colour(label);
    return colours;
  }();
  return all;
}

}  // namespace forefeel
