#pragma once
// Shared by the tests of studies: a folder with a scene of a small linear body, and errors as text.

#include <filesystem>
#include <functional>
#include <string>

#include "geometry/common/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace forefeel::test {

// A linear body, because its whole state space needs only three solves.
struct StudyFixture {
  TemporaryFolder folder;
  std::filesystem::path path = folder.path();

  StudyFixture() {
    write("scene.toml",
          "[body]\nphantom = \"slab\"\nelements = 150\n[material]\nlaw = \"linear\"\nyoung = 5000.0\npoisson "
          "= 0.3\n"
          "[state_space]\nspacing = 0.006\nbox = [[-0.018, -0.018, -0.018], [0.018, 0.018, 0.018]]\n"
          "[session]\ndevice = \"path:press,speed=0.06\"\nseconds = 0.4\n");
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return folder.write(name, text);
  }
  std::filesystem::path study(const std::string& text) const {
    return write("study.toml", "scene = \"scene.toml\"\n" + text);
  }
};

// The message of the InputError that the call throws; empty if it throws none.
inline std::string refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace forefeel::test
