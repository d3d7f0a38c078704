#pragma once
// What the tests of studies share: a folder with a scene of a small linear body, and refusals as text.

#include <filesystem>
#include <functional>
#include <string>

#include "geometry/common/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace forefeel::test {

// The state space of a linear body costs three solves.
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

// What is said where the call throws an InputError; else nothing.
inline std::string refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace forefeel::test
