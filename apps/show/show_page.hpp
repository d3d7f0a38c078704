#pragma once
// A 3-D page of a body, states and a run that can be rotated and zoomed: one HTML file that needs no network and no
// other file. It is drawn by three.js (WebGL); viewer/*.js are our scripts.

#include <string>

#include "apps/show/show_content.hpp"

namespace forefeel {

// InputError, which names `file`, if three.js was missing when forefeel was built and is not installed now.
std::string show_page(const ShowContent& content, const std::string& file);

}  // namespace forefeel
