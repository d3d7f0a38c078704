#pragma once
// Runs the command in a temporary folder, as a person would.

#include "tests/support/test.hpp"

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
  // `forefeel arguments`, written as for a shell, without expansions, in this process by the entry of the program
  // (command_main). Linked with tests/support/run_command.cpp. For a process of its own, as for signals, limits and
  // pipes: shell() with executable().
  Outcome forefeel(const std::string& arguments) const;
  // The same of a command that must succeed, and its document with --json.
  Outcome run(const std::string& arguments) const;
  nlohmann::json json(const std::string& arguments) const;
  Outcome forefeel_bench(const std::string& arguments) const;  // a process
  Outcome shell(const std::string& command) const;
  std::filesystem::path write(const std::string& name, const std::string& text) const;
  std::string read(const std::string& name) const;  // fails the test if there is no such file
  bool has(const std::string& name) const { return std::filesystem::exists(path_ / name); }
  bool same(const std::string& a, const std::string& b) const;  // these files, byte for byte
  std::string files() const;  // names of all files below, sorted, one a line
  const std::filesystem::path& path() const { return path_; }

 private:
  TemporaryFolder folder_;  // holds "work", what commands print, and their cache
  std::filesystem::path path_ = folder_ / "work";
};

// A beam of 10 x 2 x 2 cm with few elements, clamped at one end, touched at the other.
std::string beam_scene(const std::string& more = "");
// A folder with that scene as beam.toml.
struct BeamShop : Workshop {
  explicit BeamShop(const std::string& more = "") { write("beam.toml", beam_scene(more)); }
};

// Text for a shell: waits until `condition` holds, or the process $p has ended.
std::string wait_until(const std::string& condition);
// A condition for a shell. A session's record of its inputs is larger than 20 kB after about 200 frames.
std::string is_larger(const std::string& file, int bytes = 20'000);
// The process $p has handlers of SIGTERM and SIGINT.
inline const std::string takes_signals = "grep -q '^SigCgt:.*[4-7c-f]..[2367abef]$' /proc/$p/status";

// Checks that a command is refused: one error line that contains every word, exit code 2, no file made or renamed.
void check_refused(const Workshop& shop, const std::string& arguments,
                   const std::vector<std::string>& mentions);
// The same of a command that has run, but for the files.
void check_refused(const Workshop::Outcome& outcome, const std::string& arguments,
                   const std::vector<std::string>& mentions);

}  // namespace forefeel::test
