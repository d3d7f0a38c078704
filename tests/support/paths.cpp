#include "tests/support/paths.hpp"

namespace forefeel::test {

std::filesystem::path source_folder() {
  return FOREFEEL_SOURCE_DIR;
}

std::filesystem::path build_folder() {
  return FOREFEEL_BINARY_DIR;
}

std::string executable() {
  return (build_folder() / "apps" / "forefeel").string();
}

std::string bench_executable() {
  return (build_folder() / "apps" / "forefeel-bench").string();
}

std::string shared_folder() {
  const std::filesystem::path folder = source_folder() / ".." / "shared" / "data";
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? folder.string() : std::string();
}

}  // namespace forefeel::test
