#pragma once
// What every HTML page of the toolkit shares: one style, escaping, no file beside it.

#include <string>
#include <string_view>

namespace forefeel {

std::string html_escaped(std::string_view text);
// A whole page around `body` (HTML); title is plain text.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace forefeel
