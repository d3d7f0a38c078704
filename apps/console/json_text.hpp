#pragma once
// Documents as text.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace forefeel {

// The one way to make text of a document: bytes that are not UTF-8 (a path may hold any) become U+FFFD.
// indent -1: one line.
std::string json_text(const nlohmann::ordered_json& document, int indent = -1);

}  // namespace forefeel
