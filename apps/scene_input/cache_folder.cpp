#include "apps/scene_input/cache_folder.hpp"

#include <unistd.h>

#include <cstdlib>
#include <system_error>

namespace forefeel {
namespace {

namespace fs = std::filesystem;

bool writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return fs::is_directory(folder, error) && access(folder.c_str(), W_OK) == 0;
}

}  // namespace

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && fs::path(cache).is_absolute() && writable_folder(fs::path(cache) / "forefeel"))
    return fs::path(cache) / "forefeel";
  if (home && *home && writable_folder(fs::path(home) / ".cache" / "forefeel"))
    return fs::path(home) / ".cache" / "forefeel";
  return {};
}

}  // namespace forefeel
