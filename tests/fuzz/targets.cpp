#include "tests/fuzz/targets.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>

#include "geometry/common/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace forefeel::fuzz {

namespace fs = std::filesystem;

void run_target(const Target& target, std::string_view input) {
  try {
    target.run(input);
  } catch (const InputError& error) {
    const std::string_view line = error.what();
    if (line.empty() || line.size() > 4000) throw std::logic_error("an error line of no or too many bytes");
    if (line.find('\n') != std::string_view::npos) throw std::logic_error("an error of more than one line");
  }
}

fs::path file_of(std::string_view name, std::string_view content) {
  // Removed at the end of the process.
  static const test::TemporaryFolder folder = [] {
    if (::access("/dev/shm", W_OK | X_OK) == 0) ::setenv("TMPDIR", "/dev/shm", 1);
    return test::TemporaryFolder();
  }();
  const fs::path file = folder / name;
  std::ofstream(file, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  return file;
}

NamedInput named_input(std::string_view input, const std::vector<std::string>& extensions) {
  const std::string_view first = input.substr(0, input.find('\n'));
  const auto known = std::ranges::find(extensions, first);
  if (known != extensions.end()) return {*known, input.substr(std::min(input.size(), first.size() + 1))};
  const unsigned char pick = input.empty() ? 0 : static_cast<unsigned char>(input.front());
  return {extensions[pick % extensions.size()], input.substr(std::min<std::size_t>(input.size(), 1))};
}

std::string named_seed(const std::string& extension, const std::string& content) {
  return extension + "\n" + content;
}

}  // namespace forefeel::fuzz
