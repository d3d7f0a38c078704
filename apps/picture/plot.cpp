#include "apps/picture/plot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "apps/picture/scratch_folder.hpp"

extern char** environ;

namespace forefeel {
namespace {

namespace fs = std::filesystem;

// Runs gnuplot without its output and returns its exit code; -1 if it cannot be started.
int run_gnuplot(const std::string& argument) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null",
                                     descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
  std::string program = "gnuplot", word = argument;
  std::array<char*, 3> words{program.data(), word.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "gnuplot", &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (failed != 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  std::string replaced;
  std::size_t begin = 0;
  for (std::size_t at = 0; (at = text.find(from, begin)) != std::string::npos; begin = at + from.size())
    replaced.append(text, begin, at - begin).append(to);
  if (begin > 0) text = replaced.append(text, begin);
}

}  // namespace

// True if gnuplot is installed. Whether it works shows only when it draws.
bool have_gnuplot() {
  static const bool have = [] {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
      const fs::path program = fs::path(folder.empty() ? "." : folder) / "gnuplot";
      std::error_code error;
      if (fs::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) return true;
    }
    return false;
  }();
  return have;
}

namespace {

// What gnuplot writes for this terminal and script; nothing if it is missing or fails.
std::optional<std::string> drawn(const std::string& terminal, const std::string& script) {
  const ScratchFolder folder;
  if (folder.path().empty() || !have_gnuplot()) return {};
  const fs::path script_file = folder.path() / "plot.gp", picture = folder.path() / "picture";
  std::ofstream(script_file) << fmt::format("set terminal {}\nset output '{}'\nset encoding utf8\n", terminal,
                                            picture.string())
                             << script << "\nunset output\n";
  if (run_gnuplot(script_file.string()) != 0) return {};
  std::ifstream in(picture, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

}  // namespace

std::optional<std::string> draw_svg(const std::string& name, int width, int height,
                                    const std::string& script) {
  const auto picture = drawn(
      fmt::format("svg size {},{} dynamic font 'Helvetica,Arial,sans-serif,13' linewidth 1", width, height),
      script);
  const std::size_t begin = picture ? picture->find("<svg") : std::string::npos;
  if (begin == std::string::npos) return {};
  std::string svg = picture->substr(begin);
  replace_all(svg, "<title>Gnuplot</title>", "");
  for (const std::string id : {"gpPt", "gpDot", "gnuplot_plot_", "gridicon", "textoutline"})
    replace_all(svg, id, name + "_" + id);
  return svg;
}

std::optional<std::string> draw_png(int width, int height, const std::string& script) {
  const auto picture = drawn(fmt::format("pngcairo size {},{} font 'sans,10'", width, height), script);
  return picture && picture->starts_with("\x89PNG") ? picture : std::nullopt;
}

std::optional<std::string> draw_pdf(int width, int height, const std::string& script) {
  const auto picture = drawn(
      fmt::format("pdfcairo size {:.4f},{:.4f} font 'Helvetica,10'", width / 96.0, height / 96.0), script);
  return picture && picture->starts_with("%PDF") ? picture : std::nullopt;
}

std::string plain_text(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '\'' ? std::string("''") : c == '\n' ? std::string(" ") : std::string(1, c);
  return safe;
}

std::string data_block(const std::string& name, const std::string& lines) {
  return "$" + name + " << EOD\n" + (lines.empty() ? "NaN NaN NaN NaN NaN\n" : lines) + "EOD\n";
}

std::string thinned_curve(std::span<const double> x, std::span<const double> y, std::size_t bins) {
  std::string lines;
  const std::size_t n = std::min(x.size(), y.size());
  const auto put = [&](std::size_t i) { lines += fmt::format("{:.6g} {:.6g}\n", x[i], y[i]); };
  for (std::size_t bin = 0; bin < bins && n > 0; ++bin) {
    std::size_t least = n, most = n;
    for (std::size_t i = bin * n / bins; i < (bin + 1) * n / bins; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (least == n || y[i] < y[least]) least = i;
      if (most == n || y[i] > y[most]) most = i;
    }
    if (least == n) continue;
    put(std::min(least, most));
    if (least != most) put(std::max(least, most));
  }
  return lines;
}

}  // namespace forefeel
