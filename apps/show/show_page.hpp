#pragma once
// A page that shows a body, states and a run, to be turned and zoomed: one HTML file that needs no network and no
// other file. It is drawn by three.js (WebGL); viewer/*.js are our scripts.

#include <string>

#include "apps/show/show_content.hpp"

namespace forefeel {

// InputError, which names `file`: three.js was neither there when forefeel was built nor is it installed now.
std::string show_page(const ShowContent& content, const std::string& file);

}  // namespace forefeel
