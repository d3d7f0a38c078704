#pragma once
// Text for XML, HTML and terminals from bytes of any kind: names of files, groups and units may hold bytes that are
// not UTF-8.

#include <string>
#include <string_view>

namespace forefeel {

// The text with U+FFFD in place of each byte that does not belong to a character of UTF-8 (RFC 3629, section 4), and
// of control characters that XML 1.0 forbids (section 2.2).
std::string valid_utf8(std::string_view text);
// valid_utf8 for a terminal, which also acts upon carriage returns, DEL and the controls C1; lines stay lines.
std::string printable(std::string_view text);
// valid_utf8 for HTML and XML: with &amp; &lt; &gt; &quot; in place of these characters.
std::string html_escaped(std::string_view text);

}  // namespace forefeel
