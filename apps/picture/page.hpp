#pragma once
// Shared by all HTML pages: the style and the escaping. A page needs no other file.

#include <string>
#include <string_view>

namespace forefeel {

// The text for HTML and XML. What is not UTF-8 becomes U+FFFD.
std::string html_escaped(std::string_view text);
// A complete page around `body` (HTML). title is plain text.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace forefeel
