#include "apps/scene/scene_declared.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace forefeel {

const std::vector<const SceneRowList*>& scene_rows() {
  static const std::vector<const SceneRowList*> all{&body_rows(),    &material_rows(),    &clamp_rows(),
                                                    &contact_rows(), &state_space_rows(), &model_rows(),
                                                    &session_rows(), &hand_rows()};
  return all;
}

std::vector<std::string> scene_sections() {
  std::vector<std::string> names;
  for (const SceneRowList* rows : scene_rows()) names.push_back(rows->name());
  return names;
}

bool is_scene_section(const std::string& name) {
  return std::ranges::any_of(scene_rows(), [&](const SceneRowList* rows) { return rows->name() == name; });
}

const std::vector<DeclaredTable>& scene_tables() {
  static const std::vector<DeclaredTable> all = [] {
    std::vector<DeclaredTable> tables;
    for (const SceneRowList* rows : scene_rows())
      tables.insert(tables.end(), rows->tables().begin(), rows->tables().end());
    return tables;
  }();
  return all;
}

bool exclude_each_other(const std::string& key, const std::string& other) {
  const auto among = [](const std::string& name, const SceneRowList& rows) {
    return name.starts_with(rows.name() + ".") &&
           std::ranges::find(rows.alternatives(), name.substr(rows.name().size() + 1)) !=
               rows.alternatives().end();
  };
  return key != other && std::ranges::any_of(scene_rows(), [&](const SceneRowList* rows) {
           return among(key, *rows) && among(other, *rows);
         });
}

std::string no_effect_beside(const std::string& arrivals) {
  return fmt::format(
      "has no effect where states arrive at given times ({}), since nothing is solved; expected one or the "
      "other",
      arrivals);
}

}  // namespace forefeel
