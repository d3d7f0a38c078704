#pragma once
// The rules for the size and the names of rooms and files. A room is a sub-folder of the five folders; a subject is
// a header with the source file of the same stem.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/house/layers.hpp"

namespace forefeel::house {

constexpr std::size_t least_subjects = 3, most_subjects = 30, most_lines = 400;
constexpr std::ptrdiff_t most_columns = 120;  // of a comment
constexpr std::size_t most_rooms = 50, most_arrows = 330;

struct SourceFile {
  std::string name;  // relative to the root
  std::size_t lines;
  std::vector<std::size_t> wide_comments = {};  // numbers of the lines, from 1
};
std::vector<SourceFile> read_files(
    const std::filesystem::path& root);  // .hpp and .cpp of the five folders and of tests

// Each of these returns one line per fault, and nothing if there is none.
std::vector<std::string> faults_of_size(const std::vector<SourceFile>& files);
std::vector<std::string> names_used_twice(const std::vector<SourceFile>& files);
std::vector<std::string> long_files(const std::vector<SourceFile>& files);
std::vector<std::string> wide_comments(const std::vector<SourceFile>& files);
std::vector<std::string> too_many_rooms_or_arrows(const std::vector<Include>& includes);

}  // namespace forefeel::house
