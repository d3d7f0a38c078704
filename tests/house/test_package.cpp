// The installed library: builds every example against it in a clean prefix and runs the examples.

#include <regex>

#include "tests/support/executable.hpp"

namespace {

std::string ran(const Workshop& shop, const std::string& command) {
  const Workshop::Outcome outcome = shop.shell(command);
  INFO(command << "\n" << outcome.out.substr(0, 4000) << "\n" << outcome.err.substr(0, 4000));
  REQUIRE(outcome.code == 0);
  return outcome.out;
}

double value_after(const std::string& text, const std::string& words) {
  INFO(text);
  const std::size_t at = text.find(words);
  REQUIRE(at != std::string::npos);
  return std::stod(text.substr(at + words.size()));
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += word.size()) ++n;
  return n;
}

void check_headers(const Workshop& shop) {
  const std::string include = "prefix/include/forefeel";
  const std::string unprefixed =
      "grep -rlE '#include \"(geometry|solver|approx|scheduling|apps)/' " + include;
  CHECK(shop.shell(unprefixed).out.empty());
  CHECK(shop.shell("grep -rlE '#include <(CGAL|nlohmann|CLI|toml|sqlite3)' " + include).out.empty());
  CHECK(shop.shell("find " + include + " -name '*_cgal.hpp'").out.empty());
  for (const char* header : {"forefeel.hpp", "command.hpp", "scene.hpp"})
    CHECK(fs::exists(shop.path() / include / header));
  // All headers in one file, in order and backwards, so that each is parsed before those it might lean on.
  for (const char* order : {"sort", "sort -r"})
    ran(shop,
        std::string("cd prefix/include && find forefeel -name '*.hpp' | ") + order +
            " | sed 's/.*/#include <&>/' | g++ -std=c++20 -fsyntax-only -I. -isystem /usr/include/eigen3 "
            "-DEIGEN_DONT_PARALLELIZE -x c++ -");
}

// What a program includes with the umbrella header: lengths of the longest include chains that begin at each header.
class Door {
 public:
  explicit Door(fs::path include) : include_(std::move(include)) {}

  int chain(const std::string& header) {
    if (const auto known = chains_.find(header); known != chains_.end()) return known->second;
    const std::string text = read(header);
    INFO(header);
    CHECK(std::ranges::count(text, '\n') <= 400);
    int longest = 0;
    for (const std::string& other : found(text, "#include \"([^\"]+)\""))
      longest = std::max(longest, chain(other));
    return chains_[header] = 1 + longest;
  }
  std::size_t headers() const { return chains_.size(); }

  std::string read(const std::string& header) const {
    std::ifstream in(include_ / header);
    INFO(header);
    REQUIRE(in);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // The first groups of all matches.
  static std::vector<std::string> found(const std::string& text, const std::string& pattern) {
    const std::regex regex(pattern);
    std::vector<std::string> groups;
    for (std::sregex_iterator match(text.begin(), text.end(), regex), end; match != end; ++match)
      groups.push_back((*match)[1]);
    return groups;
  }

 private:
  fs::path include_;
  std::map<std::string, int> chains_;
};

void check_door(const Workshop& shop) {
  Door door(shop.path() / "prefix/include");
  CHECK(door.chain("forefeel/forefeel.hpp") <= 14);
  CHECK(door.headers() - 1 <= 60);
  // What the umbrella header names is installed beside it.
  const auto named = Door::found(door.read("forefeel/forefeel.hpp"), "\n//   ([a-z_/]+\\.hpp) ");
  CHECK(named.size() > 10);
  for (const std::string& header : named) CHECK_FALSE(door.read("forefeel/" + header).empty());
}

void check_manual(const Workshop& shop) {
  const std::string page = ran(shop, "cat prefix/share/man/man1/forefeel.1");
  for (const char* command :
       {"mesh", "solve", "generate", "import", "export", "info", "show", "classify", "evaluate", "trace",
        "session", "replay", "study", "reproduce", "cache", "help"})
    CHECK_THAT(page, Contains(std::string(".SS forefeel ") + command + "\n"));
  CHECK_THAT(page, Contains(".SH EXAMPLES\n", "forefeel cache \\-\\-empty"));
  CHECK_THAT(page, Contains(".SH FILES\n", "~/.cache/forefeel"));
  const std::string complete =
      "source prefix/share/bash-completion/completions/forefeel; COMP_WORDS=(forefeel ";
  CHECK(ran(shop, "bash -c '" + complete + "sess); COMP_CWORD=1; _forefeel; echo ${COMPREPLY[@]}'") ==
        "session\n");
  CHECK(ran(shop, "bash -c '" + complete +
                      "session --devi); COMP_CWORD=2; _forefeel; echo ${COMPREPLY[@]}'") == "--device\n");
}

// The example command has all of `forefeel` and knows its own policy; the installed command does not.
void check_command(const Workshop& shop) {
  shop.write("beam.toml", beam_scene());
  const std::string session =
      " session beam.toml --clock virtual --seconds 0.1 --cost constant:0.01 --policy ahead --json -o run";
  const auto summary = json::parse(ran(shop, "build/command_policy" + session));
  CHECK(summary["policy"] == "ahead");
  const Workshop::Outcome unknown = shop.shell("prefix/bin/forefeel" + session);
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("'ahead'", "nearest"));
  CHECK_THAT(ran(shop, "build/command_policy --help"), Contains("reproduce", "classify"));
}

// Every link of the installed README leads to an installed file.
void check_readme(const Workshop& shop) {
  const fs::path folder = shop.path() / "prefix/share/doc/forefeel";
  const std::string text = ran(shop, "cat prefix/share/doc/forefeel/README.md");
  CHECK_THAT(text, Contains("`share/forefeel`", "# Forefeel\n"));
  const std::regex link(R"(\]\(([^)]+)\))");
  int found = 0;
  for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match, ++found) {
    INFO((*match)[1]);
    CHECK(fs::exists(folder / (*match)[1].str()));
  }
  CHECK(found >= 2);
}

}  // namespace

TEST_CASE("examples are built against the installed library in a clean prefix, and run",
          "[package]" SLOW("installs the library and builds programs with it")) {
  if (sanitized) return skip("the library is built with a sanitizer");
  const Workshop shop;
  ran(shop, "cmake --install '" + build_folder().string() + "' --prefix prefix");
  check_headers(shop);
  check_door(shop);
  check_manual(shop);
  check_readme(shop);
  ran(shop,
      "cmake -S prefix/share/forefeel/examples -B build -G Ninja -DCMAKE_BUILD_TYPE=Release "
      "-DCMAKE_PREFIX_PATH=\"$PWD/prefix\" && cmake --build build");

  // The C++ of README.md and of the guide.
  int snippets = 0;
  for (const char* page : {"README.md", "solver/README.md"}) {
    std::ifstream in(source_folder() / page);
    const std::string text{std::istreambuf_iterator<char>(in), {}}, fence = "\n```cpp\n";
    const std::size_t at = text.find(fence);
    REQUIRE(at != std::string::npos);
    shop.write("snippet/main.cpp",
               text.substr(at + fence.size(), text.find("\n```", at + 1) - at - fence.size()) + "\n");
    shop.write(
        "snippet/CMakeLists.txt",
        "cmake_minimum_required(VERSION 3.25)\nproject(snippet LANGUAGES CXX)\nfind_package(forefeel "
        "REQUIRED)\n"
        "add_executable(snippet main.cpp)\ntarget_link_libraries(snippet PRIVATE forefeel::forefeel)\n");
    ran(shop,
        "rm -rf sb && cmake -S snippet -B sb -G Ninja -DCMAKE_BUILD_TYPE=Release "
        "-DCMAKE_PREFIX_PATH=\"$PWD/prefix\" && cmake --build sb");
    CHECK_THAT(ran(shop, "sb/snippet"), Contains(" N\n"));
    ++snippets;
  }
  CHECK(snippets == 2);

  const std::string first = ran(shop, "build/first_force");
  CHECK(value_after(first, "states: ") == 125);
  CHECK(value_after(first, "relative error: ") < 0.01);
  CHECK(value_after(first, "force: ") < 0);  // against a motion along +x

  const std::string labels = ran(shop, "build/own_states");
  CHECK_THAT(labels, Contains("-80 mm: blank", "-40 mm: safe", "  0 mm: gap", " 40 mm: safe"));
  shop.write("one.csv", "x,y,z,fx,fy,fz\n0,0,0,0,0,0\n");
  CHECK_THAT(ran(shop, "build/own_states one.csv"), Contains("sparse") && !Contains("safe"));
  CHECK(shop.shell("build/own_states none.csv").code == 2);

  const std::string session = ran(shop, "build/session_in_code");
  CHECK(value_after(session, "frames ") == 2000);
  CHECK(value_after(session, "states solved ") > 10);
  CHECK(value_after(session, "can tell: ") > 50);

  const std::string policies = ran(shop, "build/own_policy");
  const double nearest = value_after(policies, "nearest: within the JND on ");
  CHECK(nearest < 60);
  CHECK(value_after(policies, "ahead: within the JND on ") > nearest + 10);

  shop.write("motion.csv", "t,x,y,z\n0,0,0,0\n0.5,0,0,-0.004\n1,0.002,0,-0.004\n");
  const std::string forces = ran(shop, "build/device motion.csv");
  CHECK(count(forces, "\n") == 1000);
  CHECK(value_after(forces, "\n0.900,") > 0.001);  // [N]
  CHECK(shop.shell("build/device none.csv").code == 2);

  check_command(shop);
  const std::string loop = ran(shop, "build/own_loop beam.toml");
  CHECK(value_after(loop, "\n3.5 s: ") > 10);                          // states
  CHECK(value_after(loop, "largest change in a millisecond ") < 100);  // [mN]
  CHECK(shop.shell("build/own_loop none.toml").code == 2);
}
