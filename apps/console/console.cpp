#include "apps/console/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <iostream>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "geometry/common/utf8.hpp"

namespace forefeel {
namespace {

std::mutex waiting_mutex;
std::vector<std::string> waiting_warnings;

std::mutex lines_mutex;     // taken before that of a line
std::mutex terminal_mutex;  // taken last
bool line_drawn = false;    // a progress line stands on the terminal

// While this lives, other text may be printed: no progress line stands in its place or comes between.
class Printing {
 public:
  Printing() : lock_(terminal_mutex) {
    if (std::exchange(line_drawn, false)) std::cerr << "\r\033[K" << std::flush;
  }

 private:
  std::lock_guard<std::mutex> lock_;
};

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void complain(std::string_view program, std::string_view line) {
  const Printing printing;
  std::cerr << program << ": " << printable(line) << '\n';
}

void flush_warnings() {
  const std::lock_guard lock(waiting_mutex);
  for (const std::string& line : waiting_warnings) complain("forefeel", "warning: " + line);
  waiting_warnings.clear();
}

void print(std::ostream& out, std::string_view text) {
  const Printing printing;
  out << text << '\n' << std::flush;
}

void answer(const Globals& globals, const std::string& line) {
  flush_warnings();
  print(globals.json ? std::cerr : std::cout, printable(line));
}

void say(const Globals& globals, const std::string& line) {
  flush_warnings();
  if (!globals.quiet) answer(globals, line);
}

void warn(const Globals&, const std::string& line) {
  const std::lock_guard lock(waiting_mutex);
  waiting_warnings.push_back(line);
}

std::string rough_time(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", 5 * std::ceil(seconds / 5));
  return fmt::format("{:.0f} min", std::round(seconds / 60));
}

namespace {

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                      : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

double seconds_left(double share, double before, double elapsed) {
  const double done = share - before;
  // The first pieces also pay for what is made once, so a small share done quickly tells little.
  const bool tells = done > 0.1 || (done > 0.01 && elapsed > 20);
  return tells && share < 1 ? elapsed * (1 - share) / done : std::nan("");
}

std::string progress_line(const std::string& title, double share, const std::string& text, double elapsed,
                          double before) {
  if (!(share >= 0))
    return fmt::format("{}  {}{}{} so far", title, text, text.empty() ? "" : ", ", clock_text(elapsed));
  const double left = seconds_left(share, before, elapsed);
  return fmt::format(
      "{} {:3.0f} %  {}{}", title, 100 * share, text,
      std::isfinite(left) ? fmt::format("{}{} left", text.empty() ? "" : ", ", clock_text(left)) : "");
}

bool line_is_due(double left, double elapsed, double silent, bool first) {
  constexpr double interval = 10, measured = 2;  // [s]
  return silent >= interval || (first && elapsed >= measured && left >= interval);
}

struct Progress::Line {
  std::mutex mutex;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  std::string title, text;
  double share = -1, before = 0;  // below 0: not known; before: done when the phase began, by an earlier run
  std::int64_t started_ns = 0, shown_ns = 0, drawn_ns = 0;  // shown: what show() gave was drawn
  std::int64_t told_ns = 0;                                 // the last line where there is no terminal
  bool given = false, first = true;                         // show() was called in this phase; no line yet
  Line* outer = nullptr;                                    // silent while this one lives
  std::atomic<bool> hidden = false;
  std::condition_variable_any stopped;
  std::jthread ticker;  // the last member: it ends first

  explicit Line(std::string name)
      : title(std::move(name)),
        started_ns(now_ns()),
        told_ns(started_ns),
        ticker([this](const std::stop_token& stop) { tick(stop); }) {
    const std::lock_guard lock(lines_mutex);
    outer = std::exchange(innermost, this);
    if (outer) outer->hidden = true;
  }
  ~Line() {
    ticker.request_stop();
    ticker.join();
    const std::lock_guard lock(lines_mutex);
    Line** at = &innermost;
    while (*at != this) at = &(*at)->outer;
    *at = outer;
    if (outer && innermost == outer) outer->resume();
    const Printing wiped;
  }
  static Line* innermost;

  void resume() {
    const std::lock_guard lock(mutex);
    told_ns = drawn_ns = now_ns();
    hidden = false;
  }

  void show(double new_share, const std::string& new_text) {
    const std::lock_guard lock(mutex);
    const std::int64_t now = now_ns();
    if (!given && now - started_ns < 1'000'000'000) before = std::clamp(new_share, 0.0, 1.0);
    share = new_share;
    text = new_text;
    given = true;
    if (!terminal) return tell_if_due(now);
    if (now - shown_ns < 100'000'000) return;
    shown_ns = now;
    draw(now);
  }
  void phase(const std::string& next) {
    const std::lock_guard lock(mutex);
    if (title == next) return;
    title = next;
    started_ns = now_ns();
    shown_ns = 0;
    given = false, first = true;
    share = -1, before = 0;
    text.clear();
  }
  void tell_if_due(std::int64_t now) {
    const double elapsed = 1e-9 * static_cast<double>(now - started_ns);
    const double left = seconds_left(share, before, elapsed),
                 silent = 1e-9 * static_cast<double>(now - told_ns);
    if (hidden || !line_is_due(left, elapsed, silent, first)) return;
    told_ns = now;
    first = false;
    flush_warnings();
    print(std::cerr, progress_line(title, share, text, elapsed, before));
  }
  void draw(std::int64_t now) {
    if (hidden) return;
    if (drawn_ns == 0) flush_warnings();
    drawn_ns = now;
    const double elapsed = 1e-9 * static_cast<double>(now - started_ns);
    const Printing printing;
    std::cerr << progress_line(title, share, text, elapsed, before) << std::flush;
    line_drawn = true;
  }
  void begin(double done, const std::string& what) {
    const std::lock_guard lock(mutex);
    started_ns = now_ns();
    share = before = done;
    text = what;
    given = true;
  }
  void note(const std::string& line) {
    const std::lock_guard lock(mutex);
    flush_warnings();
    print(std::cerr, line);
    told_ns = now_ns();
  }
  void tick(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      stopped.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; });
      const std::int64_t now = now_ns();
      if (!stop.stop_requested() && !terminal) tell_if_due(now);
      if (!stop.stop_requested() && terminal && now - std::max(drawn_ns, started_ns) > 900'000'000) draw(now);
    }
  }
};

Progress::Line* Progress::Line::innermost = nullptr;

Progress::Progress(const Globals& globals, std::string title)
    : line_(globals.quiet ? nullptr : std::make_unique<Line>(std::move(title))) {}

Progress::~Progress() = default;

void Progress::show(double share, const std::string& text) {
  if (line_) line_->show(std::max(share, 0.0), text);
}

void Progress::show(const std::string& text) {
  if (line_) line_->show(-1, text);
}

void Progress::phase(const std::string& title) {
  if (line_) line_->phase(title);
}

void Progress::begin(double share, const std::string& text) {
  if (line_) line_->begin(share, text);
}

void Progress::note(const std::string& line) {
  if (line_) line_->note(line);
}

std::function<void(std::string_view, double)> stages_of(Progress& progress, std::string_view title) {
  return [&progress, title = std::string(title)](std::string_view what, double share) {
    progress.phase(fmt::format("{}: {}", title, what));
    if (share >= 0)
      progress.show(share, "");
    else
      progress.show("");
  };
}

}  // namespace forefeel
