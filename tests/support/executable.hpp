#pragma once
// Runs the built executable in a temporary folder, as a person would.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace forefeel::test {

// A fresh folder, removed at the end. It is also the working directory of the commands that are run in it.
class Workshop {
 public:
  Workshop();

  struct Outcome {
    int code = -1;  // -1: ended by a signal
    std::string out, err;
    std::size_t error_lines() const;
    nlohmann::json json() const;  // of out; fails the test if it is not one document
  };
  Outcome forefeel(const std::string& arguments) const;  // arguments as for a shell
  Outcome forefeel_bench(const std::string& arguments) const;
  Outcome shell(const std::string& command) const;
  std::filesystem::path write(const std::string& name, const std::string& text) const;
  std::string files() const;  // names of all files below, sorted, one a line
  const std::filesystem::path& path() const { return path_; }

 private:
  TemporaryFolder folder_;  // holds "work", what commands print, and their cache
  std::filesystem::path path_ = folder_ / "work";
};

// Text for a shell: waits until `condition` holds, or the process $p has ended.
std::string wait_until(const std::string& condition);
// A condition for a shell. A session's record of its inputs is larger than 20 kB after about 200 frames.
std::string is_larger(const std::string& file, int bytes = 20'000);
// The process $p has handlers of SIGTERM and SIGINT.
inline const std::string takes_signals = "grep -q '^SigCgt:.*[4-7c-f]..[2367abef]$' /proc/$p/status";

// Checks that a command is refused: one error line that contains every word, exit code 2, no file made or renamed.
void check_refused(const Workshop& shop, const std::string& arguments,
                   const std::vector<std::string>& mentions, const std::string& program = executable());

// A beam of 10 x 2 x 2 cm with few elements, clamped at one end, touched at the other.
std::string beam_scene(const std::string& more = "");

}  // namespace forefeel::test
