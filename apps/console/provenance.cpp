#include "apps/console/provenance.hpp"

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/utsname.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/build_info.hpp"

namespace forefeel {
namespace {

std::string remembered_command = "forefeel";

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown processor";
}

nlohmann::ordered_json libraries() {
  nlohmann::ordered_json versions = nlohmann::ordered_json::parse(build_info::libraries);
  versions["SQLite"] = sqlite3_libversion();
  return versions;
}

}  // namespace

std::string shell_quoted(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                          "-_=+.,:/@%") == std::string::npos;
  if (plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

void remember_command(const std::string& program, int argc, const char* const* argv) {
  remembered_command = program;
  for (int i = 1; i < argc; ++i) remembered_command += " " + shell_quoted(argv[i]);
}

const std::string& command_line() {
  return remembered_command;
}

nlohmann::ordered_json provenance(const std::string& scene_hash) {
  utsname system{};
  uname(&system);
  nlohmann::ordered_json document;
  document["command"] = command_line();
  document["version"] = build_info::version;
  document["commit"] = build_info::commit;
  document["scene_hash"] = scene_hash;
  document["libraries"] = libraries();
  document["machine"] = fmt::format("{}, {} threads, {} {}", processor(), std::thread::hardware_concurrency(),
                                    system.sysname, system.release);
  return document;
}

std::string program_text() {
  return fmt::format("forefeel {} ({}, {})", build_info::version, build_info::commit, build_info::flags);
}

std::string version_text() {
  std::string text = program_text() + '\n';
  const nlohmann::ordered_json versions = libraries();
  for (const auto& [library, version] : versions.items())
    text += fmt::format("{} {}\n", library, version.get<std::string>());
  return text + "GPL-3.0-or-later; linked with TetGen (AGPL-3.0), this binary is under AGPL-3.0.";
}

}  // namespace forefeel
