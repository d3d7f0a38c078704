#pragma once
// Output to the terminal, shared by all commands: their common options, lines for people, warnings, and one
// progress line.

#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

// Wall time since `start` [s].
double seconds_since(std::chrono::steady_clock::time_point start);

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
// Prints "forefeel: warning: …" to stderr. The warning waits until the command prints something else or succeeds, so
// that a later input error is the only line on stderr.
void warn(const Globals& globals, const std::string& line);
void flush_warnings();
void print(std::ostream& out, std::string_view text);  // a line in place of a progress line
// A line to stderr, after the program's name. All errors and warnings come here: bytes of a file that a terminal would
// act upon are replaced.
void complain(std::string_view program, std::string_view line);

// One progress line on stderr, redrawn at most 10 times a second and at least once a second, so that the time advances
// during long steps. If stderr is not a terminal: a new line when line_is_due(). For any thread. Every command has one
// with its name; while one made later lives, it is silent.
class Progress {
 public:
  Progress(const Globals& globals, std::string title);
  ~Progress();  // clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(double share,
            const std::string& text);  // share in [0, 1] of the phase; gives the time left in it
  void show(const std::string& text);  // the remaining work is unknown; shows the time so far
  // Begins the next phase: sets the title of the line and restarts its time. No effect if the title is the same.
  void phase(const std::string& title);
  // The phase begins now with this share done, by an earlier run: it does not count in the time left.
  void begin(double share, const std::string& text);
  void note(const std::string& line);  // a line of its own that stays

 private:
  struct Line;
  std::unique_ptr<Line> line_;  // null: prints nothing
};

// Shows work that tells what it does and its share done, NaN where that is not known: each kind is a phase.
std::function<void(std::string_view, double)> stages_of(Progress& progress, std::string_view title);

// As said of an estimate: "35 s", "7 min".
std::string rough_time(double seconds);
// Of work of which `before` was done when it began and `share` is now; NaN where too little is done to tell [s].
double seconds_left(double share, double before, double elapsed);
// Without a terminal: after 10 s without a line, and once 2 s of work show that at least 10 s more are needed.
// left, elapsed: of the phase [s]; silent: since the last line [s]; first: no line yet in this phase.
bool line_is_due(double left, double elapsed, double silent, bool first);

// The line: "title  62 %  text, 0:34 left"; with a share below 0, "title  text, 0:34 so far". elapsed [s].
std::string progress_line(const std::string& title, double share, const std::string& text, double elapsed,
                          double before = 0);

}  // namespace forefeel
