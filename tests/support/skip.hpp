#pragma once
// Tests that need a tool which is not installed. A run in which every check passed but a test was skipped ends
// with exit code 77, which ctest reports as "Skipped" together with the reasons. A failed check comes first.
//
//   if (!has_command("ccx")) return skip("ccx is not installed");

#include <string>
#include <vector>

namespace forefeel::test {

constexpr int skipped_exit_code = 77;

void skip(const std::string& reason);
const std::vector<std::string>& skipped();  // the reasons so far

bool has_command(const std::string& name);          // found in PATH
bool has_python_module(const std::string& module);  // /usr/bin/python3 can import it

}  // namespace forefeel::test
