#include "apps/scene/scene_hand.hpp"

#include <fmt/format.h>

#include "apps/scene/spec_text.hpp"

namespace forefeel {
namespace {

bool is_word(const SceneTable& hand, const std::string& key) {
  for (const char* word : {"light", "medium", "firm"})
    if (hand.is_text(key, word)) return true;
  return key == "target";
}

}  // namespace

std::vector<Declared> hand_keys() {
  for (const DeclaredTable& table : device_tables()) {
    if (table.name != "hand") continue;
    std::vector<Declared> keys = table.rows;
    keys.front().name = "profile";
    for (Declared& key : keys)
      if (key.name == "drawn") key = {"drawn", "", "false", key.meaning.replace(0, 3, "true")};
    return keys;
  }
  return {};
}

std::optional<std::string> device_of_hand(const SceneTable& hand) {
  bool any = false;
  for (const Declared& key : hand_keys()) any = hand.has(key.name) || any;
  if (!any) return {};
  std::string text = "hand:" + hand.text(hand.exactly_one_of({"profile"})).value_or("");
  for (const Declared& key : hand_keys()) {
    if (key.name == "profile" || !hand.has(key.name)) continue;
    if (key.name == "drawn")
      text += *hand.boolean(key.name) ? ",drawn=yes" : "";
    else if (is_word(hand, key.name))
      text += fmt::format(",{}={}", key.name, *hand.text(key.name));
    else
      text += fmt::format(",{}={}", key.name, *hand.number(key.name, not_negative()));
  }
  return text;
}

}  // namespace forefeel
