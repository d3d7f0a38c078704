#include "apps/console/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
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

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void complain(std::string_view program, std::string_view line) {
  std::cerr << program << ": " << printable(line) << '\n';
}

void flush_warnings() {
  const std::lock_guard lock(waiting_mutex);
  for (const std::string& line : waiting_warnings) complain("forefeel", "warning: " + line);
  waiting_warnings.clear();
}

void answer(const Globals& globals, const std::string& line) {
  flush_warnings();
  (globals.json ? std::cerr : std::cout) << printable(line) << '\n' << std::flush;
}

void say(const Globals& globals, const std::string& line) {
  flush_warnings();
  if (!globals.quiet) answer(globals, line);
}

void warn(const Globals&, const std::string& line) {
  const std::lock_guard lock(waiting_mutex);
  waiting_warnings.push_back(line);
}

namespace {

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                      : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

std::string progress_line(const std::string& title, double share, const std::string& text, double elapsed) {
  if (!(share >= 0)) return fmt::format("{}  {}, {} so far", title, text, clock_text(elapsed));
  std::string left;
  if (share > 0.01 && share < 1) left = fmt::format(", {} left", clock_text(elapsed * (1 - share) / share));
  return fmt::format("{} {:3.0f} %  {}{}", title, 100 * share, text, left);
}

struct Progress::Line {
  std::mutex mutex;
  std::string title, text;
  double share = 0;
  std::int64_t started_ns = 0, shown_ns = 0, drawn_ns = 0;  // shown: what show() gave was drawn
  std::condition_variable_any stopped;
  std::jthread ticker;  // the last member: it ends first

  explicit Line(std::string name)
      : title(std::move(name)),
        started_ns(now_ns()),
        ticker([this](const std::stop_token& stop) { tick(stop); }) {}

  void show(double new_share, const std::string& new_text) {
    const std::lock_guard lock(mutex);
    const std::int64_t now = now_ns();
    share = new_share;
    text = new_text;
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
  }
  void draw(std::int64_t now) {
    if (drawn_ns == 0) flush_warnings();
    drawn_ns = now;
    const double elapsed = 1e-9 * static_cast<double>(now - started_ns);
    std::cerr << "\r\033[K" << progress_line(title, share, text, elapsed) << std::flush;
  }
  void tick(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      stopped.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; });
      const std::int64_t now = now_ns();
      if (!stop.stop_requested() && drawn_ns > 0 && now - drawn_ns > 900'000'000) draw(now);
    }
  }
};

Progress::Progress(const Globals& globals, std::string title)
    : line_(!globals.quiet && isatty(STDERR_FILENO) != 0 ? std::make_unique<Line>(std::move(title))
                                                         : nullptr) {}

Progress::~Progress() {
  if (!line_) return;
  line_->ticker.request_stop();
  line_->ticker.join();
  if (line_->drawn_ns > 0) std::cerr << "\r\033[K" << std::flush;
}

void Progress::show(double share, const std::string& text) {
  if (line_) line_->show(std::max(share, 0.0), text);
}

void Progress::show(const std::string& text) {
  if (line_) line_->show(-1, text);
}

void Progress::phase(const std::string& title) {
  if (line_) line_->phase(title);
}

}  // namespace forefeel
