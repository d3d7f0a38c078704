#pragma once
// The colours of `forefeel show`, by what they stand for; those of labels are the ones of all pictures.

#include <map>
#include <string>

namespace forefeel {

const std::map<std::string, std::string>& show_colours();  // "safe" -> "#0b4f7d", "body", "clamp", …

}  // namespace forefeel
