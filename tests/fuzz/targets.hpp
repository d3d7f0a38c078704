#pragma once
// Fuzz targets: every reader of something that a person hands in. A target takes any bytes. It must return, or
// throw an InputError of one short line; run_target() checks that. The same targets run under libFuzzer
// (libfuzzer.cpp) and, without it, on mutations of their seeds (test_seeds.cpp).

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel::fuzz {

struct Target {
  const char* name;
  void (*run)(std::string_view input);
  std::vector<std::string> (*seeds)();  // valid inputs, from which mutations start
};

// Runs a target on an input. Throws std::logic_error, with the reason, if the target violates the rule above.
void run_target(const Target& target, std::string_view input);

// For targets that read files: a file of this name in memory where the system has such a folder. The same
// name is written again each time.
std::filesystem::path file_of(std::string_view name, std::string_view content);

// Inputs of readers of several formats: a line with the name of the file, then its content.
struct NamedInput {
  std::string_view extension, content;  // extension: one of those given
};
NamedInput named_input(std::string_view input, const std::vector<std::string>& extensions);
std::string named_seed(const std::string& extension, const std::string& content);

// The targets, one function for each file.
std::vector<Target> geometry_targets();
std::vector<Target> table_targets();
std::vector<Target> text_targets();

}  // namespace forefeel::fuzz
