// Digests of the sources: cached files are valid for one revision of the code that made them.
// A digest whose patterns match nothing would never change, so configuring must fail (forefeel_revision in
// the top CMakeLists.txt).

#include <regex>

#include "tests/support/executable.hpp"

namespace {

// A project that calls the repository's own forefeel_revision on its folder `rooms`.
void write_project(const Workshop& shop, const std::string& patterns) {
  const std::string cmake = text_of(source_folder() / "CMakeLists.txt");
  const std::size_t begin = cmake.find("function(forefeel_revision"),
                    end = cmake.find("endfunction()", begin);
  REQUIRE(end != std::string::npos);
  shop.write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(digest LANGUAGES NONE)\n" +
                                   cmake.substr(begin, end - begin) + "endfunction()\n" +
                                   "forefeel_revision(digest seed " + patterns +
                                   ")\nfile(WRITE digest.txt ${digest})\n");
}

std::string digest_of(const Workshop& shop) {
  REQUIRE(shop.shell("cmake -G Ninja -S . -B build").code == 0);
  return text_of(shop.path() / "digest.txt");
}

}  // namespace

TEST_CASE("a digest changes with each file that it covers, and covers at least one", "[revision]") {
  const Workshop shop;
  shop.write("rooms/one/a.cpp", "int a;");
  shop.write("rooms/two/b.hpp", "int b;");
  write_project(shop, "rooms/*/*.cpp rooms/*/*.hpp");
  const std::string before = digest_of(shop);
  CHECK(before.size() == 64);
  CHECK(digest_of(shop) == before);
  shop.write("rooms/two/b.hpp", "int b;  // a comment; of two words");
  CHECK(digest_of(shop) == before);
  shop.write("rooms/two/b.hpp", "int c;  // a comment");
  CHECK(digest_of(shop) != before);
  write_project(shop, "rooms/*.cpp");
  const Workshop::Outcome refused = shop.shell("cmake -G Ninja -S . -B build");
  CHECK(refused.code != 0);
  CHECK_THAT(refused.err, Contains("a revision covers no file"));
}

// The patterns that the build itself uses, followed from the folder of their CMakeLists.txt.
TEST_CASE("each digest of the build covers sources of every room it is about", "[revision]") {
  const auto matches = [](const fs::path& folder, const std::string& pattern) {
    std::string expression = "'" + folder.string() + "/'" + pattern;
    return Workshop().shell("ls " + expression + " | wc -l").out;
  };
  int digests = 0, patterns = 0;
  const std::regex call(R"(forefeel_revision\((\w+)\s+"[^"]*"([^)]*)\))"), word(R"([^\s]+)");
  for (const char* folder : {"geometry", "solver", "approx", "scheduling", "apps"}) {
    const std::string text = text_of(source_folder() / folder / "CMakeLists.txt");
    for (std::sregex_iterator found(text.begin(), text.end(), call), end; found != end; ++found, ++digests) {
      const std::string list = (*found)[2];
      for (std::sregex_iterator pattern(list.begin(), list.end(), word); pattern != end;
           ++pattern, ++patterns) {
        INFO(folder << "/CMakeLists.txt: " << pattern->str());
        CHECK(std::stoi(matches(source_folder() / folder, pattern->str())) > 0);
      }
    }
  }
  CHECK(digests >= 2);
  CHECK(patterns >= 4);
}
