#pragma once
// Rules about the keys of a scene: which exclude each other, and which have no effect.

#include <string>
#include <utility>
#include <vector>

namespace forefeel {

inline constexpr double usual_tolerance = 0.07;  // state_space.tolerance where the scene gives none [1]

// Sections with keys that exclude each other: {"contact", {"node", "nodes", "nearest", "group"}}, … An
// override of one key removes the others.
const std::vector<std::pair<std::string, std::vector<std::string>>>& alternative_keys();
// True for two different keys of one such list, given with their section: "contact.node", "contact.group".
bool exclude_each_other(const std::string& key, const std::string& other);

// Keys of [session] that only control which states are solved, by which worker and when. They have no effect if states
// arrive at given times.
const std::vector<std::string>& scheduling_keys();
// "has no effect where states arrive at given times (<arrivals>), …"
std::string no_effect_beside(const std::string& arrivals);

}  // namespace forefeel
