#include "apps/scene/scene_hand.hpp"

#include <fmt/format.h>

#include "apps/scene/scene_declared.hpp"
#include "apps/scene/spec_text.hpp"

namespace forefeel {
namespace {

bool is_word(const SceneTable& hand, const std::string& key) {
  for (const char* word : {"light", "medium", "firm"})
    if (hand.is_text(key, word)) return true;
  return key == "target";
}

struct NoOptions {};  // a text is made of the keys

SceneRows<NoOptions> rows_of_hand() {
  SceneRows<NoOptions> rows("hand", "The same as session.device = \"hand:PROFILE,…\", in place of it.");
  for (const DeclaredTable& table : device_tables()) {
    if (table.name != "hand") continue;
    for (Declared key : table.rows) {
      if (key.name == "PROFILE") key.name = "profile";
      if (key.name == "drawn") key = {"drawn", "", "false", key.meaning.replace(0, 3, "true")};
      rows = std::move(rows).row(std::move(key));
    }
  }
  return rows;
}

}  // namespace

const SceneRowList& hand_rows() {
  static const SceneRows<NoOptions> rows = rows_of_hand();
  return rows;
}

std::optional<std::string> device_of_hand(const SceneTable& hand) {
  bool any = false;
  for (const std::string& key : hand_rows().names()) any = hand.has(key) || any;
  if (!any) return {};
  std::string text = "hand:" + hand.text(hand.exactly_one_of({"profile"})).value_or("");
  for (const std::string& key : hand_rows().names()) {
    if (key == "profile" || !hand.has(key)) continue;
    if (key == "drawn")
      text += *hand.boolean(key) ? ",drawn=yes" : "";
    else if (is_word(hand, key))
      text += fmt::format(",{}={}", key, *hand.text(key));
    else
      text += fmt::format(",{}={}", key, *hand.number(key, not_negative()));
  }
  return text;
}

}  // namespace forefeel
