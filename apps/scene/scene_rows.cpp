#include "apps/scene/scene_rows.hpp"

#include "apps/scene/spec_text.hpp"

namespace forefeel {

Registered part_of(const SceneTable& table, const std::string& key, const std::vector<std::string>& names) {
  Registered part = part_from_text(key, *table.text(key));
  chosen_word(table, key, part.name, names, "; one that a program registers exists in it alone");
  return part;
}

void SceneRowList::check_required(const SceneTable& table) const {
  for (const auto& [key, expected] : required_)
    if (!table.has(key)) throw table.wrong(key, expected);
}

}  // namespace forefeel
