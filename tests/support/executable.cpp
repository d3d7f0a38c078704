#include "tests/support/executable.hpp"

#include <sys/wait.h>

namespace forefeel::test {

Workshop::Workshop() {
  fs::create_directory(path_);
}

Workshop::Outcome Workshop::shell(const std::string& command) const {
  const fs::path out = folder_ / "out", err = folder_ / "err";
  const std::string line = "cd '" + path_.string() + "' && export XDG_CACHE_HOME='" +
                           (folder_ / "cache").string() + "' && { " + command + "\n} >'" + out.string() +
                           "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
}

Workshop::Outcome Workshop::forefeel_bench(const std::string& arguments) const {
  return shell("'" + bench_executable() + "' " + arguments);
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
  return folder_.write("work/" + name, text);
}

std::string Workshop::read(const std::string& name) const {
  REQUIRE(fs::is_regular_file(path_ / name));
  return text_of(path_ / name);
}

bool Workshop::same(const std::string& a, const std::string& b) const {
  return read(a) == read(b);
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

std::string wait_until(const std::string& condition) {
  return "while ! { " + condition + "; } && kill -0 $p 2>/dev/null; do sleep 0.01; done; ";
}

std::string is_larger(const std::string& file, int bytes) {
  return "[ $(stat -c %s " + file + " 2>/dev/null || echo 0) -gt " + std::to_string(bytes) + " ]";
}

void check_refused(const Workshop::Outcome& outcome, const std::string& arguments,
                   const std::vector<std::string>& mentions) {
  INFO(arguments << "\nstdout: " << outcome.out << "\nstderr: " << outcome.err);
  CHECK(outcome.code == 2);
  CHECK(outcome.error_lines() == 1);
  CHECK(outcome.err.ends_with('\n'));
  CHECK(outcome.out.empty());
  for (const std::string& word : mentions) CHECK_THAT(outcome.err, Contains(word));
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
