#pragma once
// Every key of a scene: name, unit, default and meaning. SceneTable accepts only these keys, and `forefeel help scene`
// prints them.

#include <string>
#include <vector>

#include "geometry/common/declared.hpp"

namespace forefeel {

// The tables of a scene in the order of a file; nested ones behind their parent: "session", "session.jnd" …
const std::vector<DeclaredTable>& scene_tables();
// Keys of one table; "" is the scene itself, whose keys are the names of its tables. Throws std::logic_error
// for a table that is not declared.
std::vector<std::string> keys_of(const std::string& table);

}  // namespace forefeel
