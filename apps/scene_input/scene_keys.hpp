#pragma once
// What is known of the keys of a scene beside their values.

#include <string>
#include <utility>
#include <vector>

namespace forefeel {

// Sections with keys of which only one may be given: {"contact", {"node", "nodes", "nearest", "group"}}, … An
// override of one of them removes the others.
const std::vector<std::pair<std::string, std::vector<std::string>>>& alternative_keys();
// True for two different keys of one such list, with their section: "contact.node", "contact.group".
bool exclude_each_other(const std::string& key, const std::string& other);

// Keys of [session] that only say what is solved, by whom and when. They have no effect where states arrive
// at given times.
const std::vector<std::string>& scheduling_keys();
// "has no effect where states arrive at given times (<arrivals>), …"
std::string no_effect_beside(const std::string& arrivals);

}  // namespace forefeel
