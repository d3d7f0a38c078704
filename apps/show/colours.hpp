#pragma once
// The colours of `forefeel show` by meaning. Labels have the same colours in all pictures.

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace forefeel {

// Of region i of a body, from 0; they repeat. They are the curves' colours of the palette in use.
std::string region_colour(std::size_t i);

// The colour of a meaning.
const std::string& ink(std::string_view meaning);
const std::map<std::string, std::string>& show_colours();  // "safe" -> "#0b4f7d", "body", "clamp", …

}  // namespace forefeel
