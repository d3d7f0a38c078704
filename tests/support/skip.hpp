#pragma once
// Tests that need a tool which is not installed. A run that skipped a test, and whose checks all pass, ends
// with exit code 77. ctest reports it as skipped.
//
//   if (!has_command("ccx")) return skip("ccx is not installed");

#include <string>
#include <vector>

namespace forefeel::test {

constexpr int skipped_exit_code = 77;

void skip(const std::string& reason);
const std::vector<std::string>& skipped();  // the reasons so far

// Runs /usr/bin/python3 with these words. False, and the test counts as skipped, where the script ends with 77 for a
// module that is missing, or where there is no Python. Any other failure fails the test.
bool python_ran(const std::string& words, const std::string& missing);

bool has_command(const std::string& name);          // found in PATH
bool has_python_module(const std::string& module);  // /usr/bin/python3 can import it

}  // namespace forefeel::test
