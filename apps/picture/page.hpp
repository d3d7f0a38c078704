#pragma once
// Shared by all HTML pages: the style. A page needs no other file.

#include <string>
#include <vector>

#include "geometry/common/utf8.hpp"

namespace forefeel {

// Values as whole multiples of `scale`, so that two bytes hold each, in base64 for a script.
std::string base64_of_whole(const std::vector<double>& values, double& scale);
// A complete page around `body` (HTML). title is plain text.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace forefeel
