#pragma once
// Output to the terminal, shared by all commands: their common options, lines for people, warnings, and one
// progress line.

#include <cstdint>
#include <string>
#include <vector>

namespace forefeel {

struct Globals {
  bool json = false;  // print one JSON document to stdout and all other text to stderr
  bool quiet = false;
  int threads = 0;  // 0: all cores
  std::uint64_t seed = 0;
  std::vector<std::string> set;  // each "key.path=value" of --set, which overrides the scene
};

// Prints a line for people to stdout, or to stderr with --json. Prints nothing with --quiet.
void say(const Globals& globals, const std::string& line);
// Prints a result for people: as say(), but also with --quiet.
void answer(const Globals& globals, const std::string& line);
// Prints "forefeel: warning: …" to stderr. It is held back until the command prints something else or
// succeeds, so that a later input error is the only line on stderr.
void warn(const Globals& globals, const std::string& line);
void flush_warnings();

// One progress line on stderr, redrawn at most 10 times a second. Prints nothing if stderr is not a terminal.
class Progress {
 public:
  Progress(const Globals& globals, std::string title);
  ~Progress();                                       // clears the line
  void show(double share, const std::string& text);  // share in [0, 1]; gives the remaining time

 private:
  bool live_;
  std::string title_;
  std::int64_t started_ns_ = 0, shown_ns_ = 0;
};

}  // namespace forefeel
