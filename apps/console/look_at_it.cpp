#include "apps/console/look_at_it.hpp"

#include "apps/console/provenance.hpp"

namespace forefeel {

std::string look_at_it(const Globals& globals, const std::filesystem::path& what, const std::string& scene) {
  std::string line = "look at it: forefeel show " + shell_quoted(what.string());
  if (!scene.empty()) {
    line += " --scene " + shell_quoted(scene);
    for (const std::string& set : globals.set) line += " --set " + shell_quoted(set);
  }
  std::error_code error;
  const bool folder = std::filesystem::is_directory(what, error);
  const std::filesystem::path page =
      folder ? what / "show.html" : std::filesystem::path(what).replace_extension(".html");
  return line + " -o " + shell_quoted(page.string());
}

}  // namespace forefeel
