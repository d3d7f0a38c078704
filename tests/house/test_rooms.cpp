// The rules for the size and the names of rooms and files (rooms.hpp): the tree keeps them, and a fault put in for the
// purpose is found.

#include <iostream>

#include "tests/house/rooms.hpp"
#include "tests/support/test.hpp"

using namespace forefeel::house;

namespace {

void check_none(const std::vector<std::string>& faults) {
  for (const std::string& fault : faults) std::cerr << "  " << fault << '\n';
  CHECK(faults.empty());
}

// Subjects a, b, … of a room, each a header.
void fill(const TemporaryFolder& root, const std::string& room, std::size_t subjects) {
  for (std::size_t i = 0; i < subjects; ++i)
    root.write(room + "/" + room.substr(room.find('/') + 1) + std::to_string(i) + ".hpp", "#pragma once\n");
}

}  // namespace

TEST_CASE("a room holds 3 to 30 subjects", "[rooms]") {
  check_none(faults_of_size(read_files(source_folder())));
  const TemporaryFolder root;
  fill(root, "geometry/mesh", 3);
  fill(root, "geometry/index", 30);
  root.write("geometry/index/index0.cpp", "");  // of the same subject
  root.write("scheduling/door.hpp", "");        // in no room
  root.write("apps/examples/one.cpp", "");
  CHECK(faults_of_size(read_files(root.path())).empty());
  fill(root, "solver/body", 2);
  root.write("geometry/index/more.cpp", "");
  CHECK(faults_of_size(read_files(root.path())) ==
        std::vector<std::string>{"geometry/index holds 31 subjects, expected 3 to 30",
                                 "solver/body holds 2 subjects, expected 3 to 30"});
}

TEST_CASE("no two rooms of a folder have one name, and no two files of the tree", "[rooms]") {
  check_none(names_used_twice(read_files(source_folder())));
  const TemporaryFolder root;
  root.write("apps/main/main.cpp", "");
  root.write("tests/support/main.cpp", "");
  root.write("solver/common/sum.hpp", "");
  root.write("geometry/common/sum.cpp", "");
  CHECK(names_used_twice(read_files(root.path())).empty());
  root.write("tests/geometry/sum.cpp", "");
  root.write("geometry/mesh/common/text.hpp", "");
  CHECK(names_used_twice(read_files(root.path())) ==
        std::vector<std::string>{"one name, common: geometry/common, geometry/mesh/common",
                                 "one name, sum.cpp: geometry/common/sum.cpp, tests/geometry/sum.cpp"});
}

TEST_CASE("no source file of the five folders has more than 400 lines", "[rooms]") {
  check_none(long_files(read_files(source_folder())));
  const TemporaryFolder root;
  root.write("geometry/mesh/a.cpp", std::string(400, '\n'));
  root.write("geometry/mesh/b.hpp", std::string(401, '\n'));
  root.write("tests/geometry/c.cpp", std::string(401, '\n'));
  CHECK(long_files(read_files(root.path())) ==
        std::vector<std::string>{"geometry/mesh/b.hpp has 401 lines, expected at most 400"});
}

TEST_CASE("no comment is wider than 120 columns", "[rooms]") {
  check_none(wide_comments(read_files(source_folder())));
  const TemporaryFolder root;
  root.write("geometry/mesh/a.cpp",
             "\n  // " + std::string(115, 'x') + "\nint wide = 0;  // " + std::string(115, 'x') + "\n");
  CHECK(wide_comments(read_files(root.path())).empty());
  root.write("geometry/mesh/b.hpp", "\n  // " + std::string(116, 'x') + "\n");
  root.write("geometry/mesh/c.hpp", "// \u03b1" + std::string(116, 'x') + "\n");  // a letter of two bytes
  CHECK(wide_comments(read_files(root.path())) ==
        std::vector<std::string>{"geometry/mesh/b.hpp:2 has a comment of more than 120 columns"});
}

TEST_CASE("at most 50 rooms, and at most 330 arrows between them", "[rooms]") {
  check_none(too_many_rooms_or_arrows(read_includes(source_folder())));
  std::vector<Include> includes;
  const auto room = [](std::size_t i) { return "solver/room" + std::to_string(i); };
  const auto arrow = [&](std::size_t from, std::size_t to) {
    includes.push_back({room(from) + "/a.cpp", 1, room(to) + "/a.hpp", true});
  };
  for (std::size_t i = 0; i < 50; ++i)
    for (std::size_t j = 1; j <= (i < 30 ? 7u : 6u); ++j) arrow(i, (i + j) % 50);
  arrow(0, 1);  // there already
  CHECK(too_many_rooms_or_arrows(includes).empty());
  arrow(0, 8);
  CHECK(too_many_rooms_or_arrows(includes) == std::vector<std::string>{"331 arrows, expected at most 330"});
  arrow(50, 0);
  CHECK(too_many_rooms_or_arrows(includes) ==
        std::vector<std::string>{"51 rooms, expected at most 50", "332 arrows, expected at most 330"});
}
