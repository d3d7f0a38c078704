#include "apps/picture/scratch_folder.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <string>
#include <string_view>

namespace forefeel {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view folder_prefix = "forefeel-tmp-";

// Removes the folders of processes that ended without doing so.
void sweep_folders(const fs::path& above) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(above, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(folder_prefix)) continue;
    int process = 0;
    const char* const end = name.data() + name.size();
    const auto [rest, bad] = std::from_chars(name.data() + folder_prefix.size(), end, process);
    if (bad != std::errc{} || process <= 0 || rest == end || *rest != '-') continue;
    if (kill(process, 0) != 0 && errno == ESRCH) fs::remove_all(entry.path(), error);
  }
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::error_code error;
  const fs::path above = fs::temp_directory_path(error);
  if (error) return;
  sweep_folders(above);
  std::string pattern = (above / fmt::format("{}{}-XXXXXX", folder_prefix, getpid())).string();
  if (mkdtemp(pattern.data())) path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code error;
  if (!path_.empty()) fs::remove_all(path_, error);
}

}  // namespace forefeel
