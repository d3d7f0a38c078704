#include "tests/apps/executable.hpp"

#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace forefeel::test {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

Workshop::Workshop() {
  std::string pattern = (fs::temp_directory_path() / "forefeel-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = pattern;
  fs::create_directory(path_ / "work");
  path_ /= "work";
}

Workshop::~Workshop() {
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(path_, error))
    if (entry.is_directory()) fs::permissions(entry.path(), fs::perms::owner_all, error);
  fs::remove_all(path_.parent_path(), error);
}

Workshop::Outcome Workshop::shell(const std::string& command) const {
  const fs::path out = path_.parent_path() / "out", err = path_.parent_path() / "err";
  const std::string line = "cd '" + path_.string() + "' && export XDG_CACHE_HOME='" +
                           (path_.parent_path() / "cache").string() + "' && { " + command + "\n} >'" +
                           out.string() + "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(out), read(err)};
}

Workshop::Outcome Workshop::forefeel(const std::string& arguments) const {
  return shell("'" FOREFEEL_BINARY_DIR "/apps/forefeel' " + arguments);
}

std::size_t Workshop::Outcome::error_lines() const {
  return static_cast<std::size_t>(std::ranges::count(err, '\n'));
}

nlohmann::json Workshop::Outcome::json() const {
  nlohmann::json document = nlohmann::json::parse(out, nullptr, false);
  INFO("stdout: " << out.substr(0, 2000) << "\nstderr: " << err);
  REQUIRE_FALSE(document.is_discarded());
  return document;
}

fs::path Workshop::write(const std::string& name, const std::string& text) const {
  fs::create_directories((path_ / name).parent_path());
  std::ofstream(path_ / name, std::ios::binary) << text;
  return path_ / name;
}

std::string Workshop::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(path_))
    names.push_back(entry.path().lexically_relative(path_).string());
  std::ranges::sort(names);
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  return text;
}

void check_refused(const Workshop& shop, const std::string& arguments,
                   const std::vector<std::string>& mentions) {
  const std::string before = shop.files();
  const Workshop::Outcome outcome = shop.forefeel(arguments);
  INFO("forefeel " << arguments << "\nstdout: " << outcome.out << "\nstderr: " << outcome.err);
  CHECK(outcome.code == 2);
  CHECK(outcome.error_lines() == 1);
  CHECK(outcome.err.ends_with('\n'));
  CHECK(outcome.out.empty());
  for (const std::string& word : mentions) CHECK_THAT(outcome.err, Catch::Contains(word));
  CHECK(shop.files() == before);
}

std::string beam_scene(const std::string& more) {
  return R"([body]
phantom = "beam"
elements = 240
[material]
law = "neo-hookean"
young = 5000.0
poisson = 0.3
[state_space]
spacing = 0.004
box = [[-0.004, -0.004, -0.004], [0.004, 0.004, 0.004]]
)" + more;
}

}  // namespace forefeel::test
