#pragma once
// A folder under the system's temporary folder. It is removed at the end of its life, or, after a kill, when a later
// process makes one.

#include <filesystem>

namespace forefeel {

class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }  // empty if it could not be created

 private:
  std::filesystem::path path_;
};

}  // namespace forefeel
