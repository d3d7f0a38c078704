#pragma once
// Values and documents of --json.

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace forefeel {

nlohmann::ordered_json number(double value);  // null if not finite
nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value);
void print_json(const nlohmann::ordered_json& document);  // to stdout, after the warnings held back

// JSON documents as text.

// All commands print JSON with this function. Bytes that are not UTF-8 (paths may contain any bytes) become U+FFFD.
// indent -1: one line.
std::string json_text(const nlohmann::ordered_json& document, int indent = -1);

// SHA-256 of the text, in hexadecimal digits. It is stored with kept values, so that an altered file is detected.
std::string sum_of(const nlohmann::ordered_json& value);

}  // namespace forefeel
