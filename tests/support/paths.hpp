#pragma once
// Where the sources and the build are. Only paths.cpp has these folders on its command line: a compiler cache
// serves every other test file in any folder.

#include <filesystem>
#include <string>

namespace forefeel::test {

std::filesystem::path source_folder();  // the repository
std::filesystem::path build_folder();   // the build's root, e.g. build/release
std::string executable();               // the command `forefeel`, as an absolute path
std::string bench_executable();         // the same of `forefeel-bench`, of the target forefeel_bench
std::string shared_folder();            // ../shared/data with reference data; empty where there is none

}  // namespace forefeel::test
