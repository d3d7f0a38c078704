#pragma once
// Files for ParaView, as VTK's own reader sees them (read_vtk.py).

#include "tests/support/executable.hpp"

namespace forefeel::test {

// One object for each file, or what another script of this folder prints; null (and the test counts as skipped) if VTK
// is not installed.
inline json read_by_vtk(const Workshop& shop, const std::string& files,
                        const std::string& script = "read_vtk.py") {
  const auto outcome =
      shop.shell("/usr/bin/python3 '" + (source_folder() / "tests/apps" / script).string() + "' " + files);
  if (outcome.code == 77 || outcome.code == 127) {
    skip("python3-vtk9 is not installed");
    return nullptr;
  }
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  return outcome.json();
}

}  // namespace forefeel::test
