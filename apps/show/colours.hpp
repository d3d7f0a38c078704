#pragma once
// The colours of `forefeel show` by meaning. Labels have the same colours in all pictures.

#include <map>
#include <string>

namespace forefeel {

const std::map<std::string, std::string>& show_colours();  // "safe" -> "#0b4f7d", "body", "clamp", …

}  // namespace forefeel
