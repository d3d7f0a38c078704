#pragma once
// Text for XML and HTML from bytes of any kind: names of files and groups may hold bytes that are not UTF-8.

#include <string>
#include <string_view>

namespace forefeel {

// The text with U+FFFD in place of each byte that does not belong to a character of UTF-8 (RFC 3629, section 4), and
// of control characters that XML 1.0 forbids (section 2.2).
std::string valid_utf8(std::string_view text);
// The same for HTML and XML: with &amp; &lt; &gt; &quot; in place of these characters.
std::string html_escaped(std::string_view text);

}  // namespace forefeel
