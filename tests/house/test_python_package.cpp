// The installed Python package.

#include "tests/support/executable.hpp"

TEST_CASE("the Python package is installed where the message says, and imports there",
          "[package]" SLOW("installs the Python package, which only run.sh all builds")) {
  if (!fs::exists(build_folder() / "apps" / "python" / "forefeel" / "__init__.py"))
    return skip("the Python module is not built: pybind11 is not installed");
  const Workshop shop;
  const Workshop::Outcome installed = shop.shell("cmake --install '" + build_folder().string() +
                                                 "' --component python --prefix \"$PWD/prefix\"");
  INFO(installed.out << installed.err);
  REQUIRE(installed.code == 0);
  const std::string folder = (shop.path() / "prefix/lib/python3/dist-packages").string();
  CHECK_THAT(installed.out, Contains("PYTHONPATH=" + folder));
  CHECK(fs::exists(folder + "/forefeel/_core.pyi"));
  CHECK(fs::exists(folder + "/forefeel/py.typed"));
  const Workshop::Outcome used = shop.shell("cd / && PYTHONPATH='" + folder +
                                            "' /usr/bin/python3 -c \"import forefeel as f; print(f.__file__, "
                                            "f.classify([[0,0,0]], [[0,0,1]], 0.1))\"");
  INFO(used.err);
  CHECK(used.out == folder + "/forefeel/__init__.py [3]\n");
  // Nothing of the other package comes along.
  CHECK(shop.shell("ls prefix prefix/share/doc").out ==
        "prefix:\nlib\nshare\n\nprefix/share/doc:\npython3-forefeel\n");
}
