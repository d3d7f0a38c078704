#include "tests/support/skip.hpp"

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>

namespace forefeel::test {
namespace {

std::vector<std::string>& reasons() {
  static std::vector<std::string> all;
  return all;
}

}  // namespace

void skip(const std::string& reason) {
  WARN("skipped: " << reason);
  reasons().push_back(Catch::getResultCapture().getCurrentTestName() + ": " + reason);
}

const std::vector<std::string>& skipped() {
  return reasons();
}

bool python_ran(const std::string& words, const std::string& missing) {
  const int status = std::system(("/usr/bin/python3 " + words + " 2>/dev/null").c_str());
  const bool skipped = WIFEXITED(status) && (WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127);
  if (skipped) skip(missing);
  CHECK((skipped || status == 0));
  return !skipped;
}

bool has_command(const std::string& name) {
  return std::system(("command -v '" + name + "' >/dev/null 2>&1").c_str()) == 0;
}

bool has_python_module(const std::string& module) {
  return std::system(("/usr/bin/python3 -c 'import " + module + "' >/dev/null 2>&1").c_str()) == 0;
}

}  // namespace forefeel::test
