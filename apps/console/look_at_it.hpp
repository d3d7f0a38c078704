#pragma once
// The last line that a command prints if its result can be shown.

#include <filesystem>
#include <string>

#include "apps/console/console.hpp"

namespace forefeel {

// "look at it: forefeel show liver.states --scene liver.toml -o liver.html", to be pasted into a shell. scene: empty
// if none is needed; otherwise the --set options of this command are added.
std::string look_at_it(const Globals& globals, const std::filesystem::path& what,
                       const std::string& scene = {});

}  // namespace forefeel
