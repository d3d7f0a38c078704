#pragma once
// A temporary folder for a test, removed at the end with its content.

#include <filesystem>
#include <string>
#include <string_view>

namespace forefeel::test {

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  // Writes a file, with the folders above it, and returns its path.
  std::filesystem::path write(std::string_view name, std::string_view content) const;
  std::size_t entries() const;  // files and folders directly inside

 private:
  std::filesystem::path path_;
};

}  // namespace forefeel::test
