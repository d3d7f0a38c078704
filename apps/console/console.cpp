#include "apps/console/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <mutex>

namespace forefeel {
namespace {

std::mutex waiting_mutex;
std::vector<std::string> waiting_warnings;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

void flush_warnings() {
  const std::lock_guard lock(waiting_mutex);
  for (const std::string& line : waiting_warnings) std::cerr << "forefeel: warning: " << line << '\n';
  waiting_warnings.clear();
}

void answer(const Globals& globals, const std::string& line) {
  flush_warnings();
  (globals.json ? std::cerr : std::cout) << line << '\n' << std::flush;
}

void say(const Globals& globals, const std::string& line) {
  flush_warnings();
  if (!globals.quiet) answer(globals, line);
}

void warn(const Globals&, const std::string& line) {
  const std::lock_guard lock(waiting_mutex);
  waiting_warnings.push_back(line);
}

Progress::Progress(const Globals& globals, std::string title)
    : live_(!globals.quiet && isatty(STDERR_FILENO) != 0), title_(std::move(title)), started_ns_(now_ns()) {}

Progress::~Progress() {
  if (live_ && shown_ns_ > 0) std::cerr << "\r\033[K" << std::flush;
}

void Progress::show(double share, const std::string& text) {
  if (!live_) return;
  const std::int64_t now = now_ns();
  if (now - shown_ns_ < 100'000'000) return;
  if (shown_ns_ == 0) flush_warnings();
  shown_ns_ = now;
  std::string left;
  if (share > 0.01 && share < 1) {
    const double elapsed = 1e-9 * static_cast<double>(now - started_ns_);
    const auto seconds = static_cast<long>(std::lround(elapsed * (1 - share) / share));
    left = fmt::format(", {}:{:02} left", seconds / 60, seconds % 60);
  }
  std::cerr << fmt::format("\r\033[K{} {:3.0f} %  {}{}", title_, 100 * share, text, left) << std::flush;
}

}  // namespace forefeel
