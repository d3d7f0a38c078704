#pragma once
// What every command shares with the terminal: the options that all commands take, lines for people,
// warnings, and one progress line.

#include <cstdint>
#include <string>
#include <vector>

namespace forefeel {

struct Globals {
  bool json = false;  // one document on stdout, all else on stderr
  bool quiet = false;
  int threads = 0;  // 0: all cores
  std::uint64_t seed = 0;
  std::vector<std::string> set;  // --set key.path=value, overrides of the scene
};

// A line for people: to stdout, or to stderr with --json. Silent with --quiet.
void say(const Globals& globals, const std::string& line);
// A result for people: as say(), but --quiet shows it too.
void answer(const Globals& globals, const std::string& line);
// "forefeel: warning: …" on stderr. A warning waits until the command shows something else or ends well, so
// that an input error that follows is the only line on stderr.
void warn(const Globals& globals, const std::string& line);
void flush_warnings();

// One progress line on stderr, redrawn at most 10 times a second. Silent where stderr is no terminal.
class Progress {
 public:
  Progress(const Globals& globals, std::string title);
  ~Progress();                                       // clears the line
  void show(double share, const std::string& text);  // share in [0, 1]; the remaining time follows from it

 private:
  bool live_;
  std::string title_;
  std::int64_t started_ns_ = 0, shown_ns_ = 0;
};

}  // namespace forefeel
