// The architecture: the includes in the sources must match rooms.txt, which lists which room may include
// which.

#include <iostream>

#include "tests/house/layers.hpp"
#include "tests/support/test.hpp"

using namespace forefeel::house;

namespace {

struct Sources {
  Table table = read_table(source_folder() / "tests/house/rooms.txt");
  std::vector<Include> includes = read_includes(source_folder());
};

void check_none(const Sources& sources, const std::vector<std::string>& faults) {
  if (!faults.empty())
    std::cerr << "The rooms and what they include (!! is forbidden):\n"
              << drawing(sources.table, sources.includes) << "Faults:\n";
  for (const std::string& fault : faults) std::cerr << "  " << fault << '\n';
  CHECK(faults.empty());
}

}  // namespace

TEST_CASE("the table names every room once, each below those that it may include", "[layering]") {
  const Sources sources;
  check_none(sources, faults_of_table(sources.table, sources.includes));
}

TEST_CASE("no include against the table", "[layering]") {
  const Sources sources;
  check_none(sources, forbidden_includes(sources.table, sources.includes));
}

TEST_CASE("no cycle between rooms, and none between units", "[layering]") {
  const Sources sources;
  check_none(sources, room_cycles(sources.includes));
  check_none(sources, unit_cycles(sources.includes));
}

TEST_CASE("headers that are heavy to compile are included where they are used", "[layering]") {
  const Sources sources;
  check_none(sources, misplaced_heavy_headers(sources.table, sources.includes));
}

TEST_CASE("a cycle put in for the purpose is found, with its path", "[layering]") {
  const TemporaryFolder root;
  root.write("rooms.txt",
             "solver/low :\nsolver/middle : solver/low\nsolver/high : solver/low solver/middle\n");
  root.write("solver/low/a.hpp", "#include \"solver/high/c.hpp\"\n");
  root.write("solver/middle/b.hpp", "#include \"solver/low/a.hpp\"\n");
  root.write("solver/high/c.hpp", "#pragma once\n");
  root.write("solver/high/c.cpp", "#include \"solver/high/c.hpp\"\n\n#include \"solver/middle/b.hpp\"\n");
  const Table table = read_table(root / "rooms.txt");
  const std::vector<Include> includes = read_includes(root.path());
  CHECK(faults_of_table(table, includes).empty());
  CHECK(forbidden_includes(table, includes) ==
        std::vector<std::string>{"solver/low/a.hpp:1 includes solver/high/c.hpp"});
  const std::vector<std::string> rooms = room_cycles(includes), units = unit_cycles(includes);
  REQUIRE(rooms.size() == 1);
  REQUIRE(units.size() == 1);
  CHECK_THAT(rooms[0], Catch::StartsWith("solver/high -> solver/middle -> solver/low -> solver/high\n"));
  CHECK_THAT(rooms[0], Contains("solver/high/c.cpp:3 includes solver/middle/b.hpp"));
  CHECK_THAT(units[0],
             Catch::StartsWith("solver/high/c -> solver/middle/b -> solver/low/a -> solver/high/c\n"));
  CHECK(drawing(table, includes) ==
        "solver/low    -> !!solver/high\n"
        "solver/middle -> solver/low\n"
        "solver/high   -> solver/middle\n");
}

TEST_CASE("other faults that the check is there for are found", "[layering]") {
  const TemporaryFolder root;
  root.write("rooms.txt",
             "geometry/mesh : geometry/index\ngeometry/index :\ngeometry/gone :\n"
             "<CGAL/* : geometry/mesh/*_cgal.hpp\n");
  root.write("geometry/mesh/fine_cgal.hpp", "#include <CGAL/Point_3.h>\n");
  root.write("geometry/mesh/fine.cpp", "#include \"geometry/mesh/fine_cgal.hpp\"\n");
  root.write("geometry/mesh/bad.cpp", "#include \"bad.hpp\"\n  #  include <CGAL/Point_3.h>\n");
  root.write("geometry/index/bad.cpp", "#include \"geometry/mesh/fine_cgal.hpp\"\n");
  root.write("geometry/new/a.cpp", "#include <vector>\n");
  const Table table = read_table(root / "rooms.txt");
  const std::vector<Include> includes = read_includes(root.path());
  CHECK(faults_of_table(table, includes).size() == 3);
  CHECK(forbidden_includes(table, includes).size() == 2);
  CHECK(misplaced_heavy_headers(table, includes).size() == 2);
  CHECK(room_cycles(includes).empty());
}
