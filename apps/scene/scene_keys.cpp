#include "apps/scene/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace forefeel {

const std::vector<std::pair<std::string, std::vector<std::string>>>& alternative_keys() {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> alternatives{
      {"body", {"mesh", "phantom"}},
      {"clamp", {"nodes", "group", "below"}},
      {"contact", {"node", "nodes", "nearest", "group"}}};
  return alternatives;
}

const std::vector<std::string>& scheduling_keys() {
  static const std::vector<std::string> keys{"policy",      "workers",   "cost",        "latency",
                                             "preempt",     "placement", "predictor",   "rest_first",
                                             "first_guess", "batch",     "batch_share", "workers_kind"};
  return keys;
}

bool exclude_each_other(const std::string& key, const std::string& other) {
  const auto among = [](const std::string& name, const std::string& section,
                        const std::vector<std::string>& keys) {
    return name.starts_with(section + ".") &&
           std::ranges::find(keys, name.substr(section.size() + 1)) != keys.end();
  };
  return key != other && std::ranges::any_of(alternative_keys(), [&](const auto& of) {
           return among(key, of.first, of.second) && among(other, of.first, of.second);
         });
}

std::string no_effect_beside(const std::string& arrivals) {
  return fmt::format(
      "has no effect where states arrive at given times ({}), since nothing is solved; expected one or the "
      "other",
      arrivals);
}

}  // namespace forefeel
