#pragma once
// The end of a session's report: its whole document, key by key, and where it came from.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace forefeel {

std::string all_numbers(nlohmann::ordered_json document);  // folded; without what is not known
std::string provenance_section(const nlohmann::ordered_json& document);

}  // namespace forefeel
