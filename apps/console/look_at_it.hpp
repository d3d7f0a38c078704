#pragma once
// The line with which commands end that made something to look at.

#include <filesystem>
#include <string>

#include "apps/console/console.hpp"

namespace forefeel {

// "look at it: forefeel show liver.states --scene liver.toml -o liver.html", to be pasted into a shell. scene: empty
// where none is needed; the --set of this command go with it.
std::string look_at_it(const Globals& globals, const std::filesystem::path& what,
                       const std::string& scene = {});

}  // namespace forefeel
