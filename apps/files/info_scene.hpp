#pragma once
// What `forefeel info SCENE` says: the body, its contact, and the fine body that corrects it.

#include <string>

namespace forefeel {

struct Globals;

int info_scene(const Globals& globals, const std::string& file);

}  // namespace forefeel
