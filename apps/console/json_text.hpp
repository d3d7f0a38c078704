#pragma once
// JSON documents as text.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace forefeel {

// All commands print JSON with this function. Bytes that are not UTF-8 (paths may contain any bytes) become U+FFFD.
// indent -1: one line.
std::string json_text(const nlohmann::ordered_json& document, int indent = -1);

// SHA-256 of the text, in hexadecimal digits. It is stored with kept values, so that an altered file is detected.
std::string sum_of(const nlohmann::ordered_json& value);

}  // namespace forefeel
