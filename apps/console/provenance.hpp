#pragma once
// Provenance of a result: command line, version, commit, libraries, machine.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace forefeel {

std::string shell_quoted(const std::string& word);  // for a shell, where it needs quotes
void remember_command(const std::string& program, int argc,
                      const char* const* argv);  // called once by main()
const std::string& command_line();               // as typed, quoted for a shell
nlohmann::ordered_json provenance(
    const std::string& scene_hash);  // {command, version, commit, scene_hash, libraries{}, machine}
std::string program_text();          // version and commit, in one line
std::string version_text();          // what --version prints

}  // namespace forefeel
