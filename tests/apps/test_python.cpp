// The Python package forefeel: the same numbers as the command, parts written in Python, errors as exceptions.

#include <catch2/catch.hpp>

#include "tests/support/executable.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/skip.hpp"

using namespace forefeel::test;

TEST_CASE("the Python package gives the command's numbers and runs parts written in Python") {
  const auto package = build_folder() / "apps" / "python";
  if (!std::filesystem::exists(package / "forefeel" / "__init__.py"))
    return skip("the Python module is not built: pybind11 is not installed");
  if (!has_python_module("scipy")) return skip("python3-scipy is not installed");
  const Workshop shop;
  const auto scene = shop.write("beam.toml", beam_scene());
  const auto script = source_folder() / "tests" / "apps" / "python_module.py";
  const Workshop::Outcome done =
      shop.shell("PYTHONPATH='" + package.string() + "' /usr/bin/python3 '" + script.string() + "' '" +
                 executable() + "' '" + scene.string() + "'");
  INFO(done.err);
  CHECK(done.code == 0);
}
