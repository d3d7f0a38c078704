#include "apps/console/command.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <mutex>

#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

// Warnings wait here until the command has something else to show: an input error that follows stays the only
// line.
std::mutex waiting_mutex;
std::vector<std::string> waiting_warnings;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

CLI::App& add_command(CLI::App& app, Commands& commands, const std::string& name,
                      const std::string& description, std::function<int()> run) {
  CLI::App& sub = *app.add_subcommand(name, description);
  Globals& globals = commands.globals;
  sub.option_defaults()->always_capture_default(false);
  sub.add_flag("--json", globals.json, "One JSON document on stdout, everything else on stderr")
      ->group("Everywhere");
  sub.add_flag("--quiet", globals.quiet, "Nothing but results, warnings and errors")->group("Everywhere");
  sub.add_option("--threads", globals.threads, "Threads; 0: all cores")
      ->check(CLI::Range(0, 4096))
      ->type_name("N")
      ->group("Everywhere");
  sub.add_option("--seed", globals.seed, "Seed of everything random")
      ->check([](const std::string& text) {
        errno = 0;
        std::strtoull(text.c_str(), nullptr, 0);
        const bool fits = errno == 0 && !text.starts_with('-');
        return fits ? std::string() : "is " + text + ", expected a whole number of at least 0, below 2^64";
      })
      ->type_name("N")
      ->group("Everywhere");
  sub.add_option("--set", globals.set, "Override a key of the scene: material.poisson=0.4; may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY.PATH=VALUE")
      ->group("Everywhere");
  sub.callback([&commands, run = std::move(run)] {
    commands.chosen = [&commands, run] {
      if (commands.globals.threads > 0) omp_set_num_threads(commands.globals.threads);
      return run();
    };
  });
  return sub;
}

nlohmann::ordered_json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value) {
  return nlohmann::ordered_json::array({number(value.x()), number(value.y()), number(value.z())});
}

void print_json(const nlohmann::ordered_json& document) {
  flush_warnings();
  std::cout << document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n'
            << std::flush;
}

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

namespace {

std::string refuse_unless(const std::string& text, bool (*good)(double), const char* expected) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool number = !text.empty() && *end == '\0';
  return number && std::isfinite(value) && good(value) ? ""
                                                       : fmt::format("is {}, expected {}", text, expected);
}

}  // namespace

std::string above_zero(const std::string& text) {
  return refuse_unless(
      text, [](double v) { return v > 0; }, "a number above 0");
}

std::string zero_or_more(const std::string& text) {
  return refuse_unless(
      text, [](double v) { return v >= 0; }, "a number of at least 0");
}

Eigen::Vector3d parse_vector(const std::string& text, const std::string& where) {
  const auto refuse = [&]() -> InputError {
    return {where, fmt::format("'{}' is not a position, expected three finite numbers X,Y,Z", text)};
  };
  Eigen::Vector3d value;
  const char* next = text.data();
  const char* const end = text.data() + text.size();
  const auto skip_blanks = [&] {
    while (next != end && *next == ' ') ++next;
  };
  for (int i = 0; i < 3; ++i) {
    skip_blanks();
    const auto [after, error] = std::from_chars(next, end, value[i]);
    if (error != std::errc{} || !std::isfinite(value[i])) throw refuse();
    next = after;
    skip_blanks();
    if (i < 2 && (next == end || *next++ != ',')) throw refuse();
  }
  if (next != end) throw refuse();
  return value;
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
