#pragma once
// Shared by the tests of studies: a folder with a scene of a small linear body.

#include "tests/support/test.hpp"

namespace forefeel::test {

// A linear body, because its whole state space needs only three solves.
struct StudyFixture {
  TemporaryFolder folder;
  fs::path path = folder.path();

  StudyFixture() {
    write("scene.toml",
          "[body]\nphantom = \"slab\"\nelements = 150\n[material]\nlaw = \"linear\"\nyoung = 5000.0\npoisson "
          "= 0.3\n"
          "[state_space]\nspacing = 0.006\nbox = [[-0.018, -0.018, -0.018], [0.018, 0.018, 0.018]]\n"
          "[session]\ndevice = \"path:press,speed=0.06\"\nseconds = 0.4\n");
  }
  fs::path write(const std::string& name, const std::string& text) const { return folder.write(name, text); }
  fs::path study(const std::string& text) const {
    return write("study.toml", "scene = \"scene.toml\"\n" + text);
  }
};

}  // namespace forefeel::test
