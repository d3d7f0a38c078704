// The main of every test executable. Each run has its own TMPDIR and XDG_CACHE_HOME, removed at the end.
// Runs side by side share no file.

#define CATCH_CONFIG_RUNNER
#include <stdlib.h>

#include <catch2/catch.hpp>
#include <iostream>

#include "tests/support/skip.hpp"
#include "tests/support/temporary_folder.hpp"

int main(int argc, char** argv) {
  const forefeel::test::TemporaryFolder folder;
  setenv("TMPDIR", folder.path().c_str(), 1);
  setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
  const int result = Catch::Session().run(argc, argv);
  if (result != 0 || forefeel::test::skipped().empty()) return result;
  for (const std::string& reason : forefeel::test::skipped()) std::cout << "SKIPPED " << reason << '\n';
  return forefeel::test::skipped_exit_code;
}
