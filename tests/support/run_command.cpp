// The command in this process. What its entry changes in a process is put back after each call.

#include <fcntl.h>
#include <omp.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <iostream>

#include "apps/console/console.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/main/command_main.hpp"
#include "apps/picture/palette.hpp"
#include "tests/support/executable.hpp"

namespace forefeel::test {
namespace {

// The words of a line as a shell splits it, with quotes and backslashes. Refuses what only a shell can read.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  char quote = 0;
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote == 0 && (c == ' ' || c == '\n')) {
      inside = false;
      continue;
    }
    if (!std::exchange(inside, true)) words.emplace_back();
    if (c == '\\' && quote != '\'' && i + 1 < line.size())
      words.back() += line[++i];
    else if (quote == 0 ? c == '\'' || c == '"' : c == quote)
      quote = quote == 0 ? c : '\0';
    else if (std::string_view(quote == 0     ? "|&;<>$`*?"
                              : quote == '"' ? "$`"
                                             : "")
                 .find(c) != std::string::npos)
      throw std::invalid_argument("needs a shell: " + line);
    else
      words.back() += c;
  }
  return words;
}

int real_streams[3];
std::array<struct sigaction, 32> actions;

// A crash of the command is reported by the test, so on the streams of the test.
extern "C" void forefeel_test_crash(int number) {
  for (int stream = 0; stream < 3; ++stream) dup2(real_streams[stream], stream);
  sigaction(number, &actions[static_cast<std::size_t>(number)], nullptr);
  raise(number);
}

// While it lives, stdin is empty, stdout and stderr are files in memory. They are changed by their numbers, so that
// everything arrives that threads, C functions and child processes print.
class Streams {
 public:
  Streams() {
    flush();
    for (int stream = 0; stream < 3; ++stream) {
      real_streams[stream] = fcntl(stream, F_DUPFD_CLOEXEC, 3);
      files_[stream] =
          stream == 0 ? open("/dev/null", O_RDONLY | O_CLOEXEC) : memfd_create("out", MFD_CLOEXEC);
      REQUIRE(dup2(files_[stream], stream) == stream);
    }
  }
  ~Streams() {
    flush();
    for (int stream = 0; stream < 3; ++stream) {
      dup2(real_streams[stream], stream);
      close(real_streams[stream]);
      close(files_[stream]);
    }
  }
  std::string text(int stream) const {
    flush();
    std::string text(static_cast<std::size_t>(lseek(files_[stream], 0, SEEK_END)), '\0');
    REQUIRE(pread(files_[stream], text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
    return text;
  }

 private:
  static void flush() {
    std::cout.flush();
    std::cerr.flush();
    std::fflush(nullptr);
  }
  int files_[3];
};

// The rest of what a process of its own would have to itself: handlers of signals, the folder, the cache, the number
// of threads, the colours.
class Surroundings {
 public:
  Surroundings(const fs::path& folder, const std::string& cache) {
    for (std::size_t number = 1; number < actions.size(); ++number)
      sigaction(static_cast<int>(number), nullptr, &actions[number]);
    for (const int number : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) signal(number, forefeel_test_crash);
    fs::current_path(folder);
    setenv("XDG_CACHE_HOME", cache.c_str(), 1);
    use_palette(std::string(usual_palette));
  }
  ~Surroundings() {
    { const InterruptWatch end_of_early_watch; }
    for (std::size_t number = 1; number < actions.size(); ++number)
      sigaction(static_cast<int>(number), &actions[number], nullptr);
    fs::current_path(folder_);
    setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    omp_set_num_threads(threads_);
    omp_set_dynamic(dynamic_);
  }

 private:
  fs::path folder_ = fs::current_path();
  std::string cache_ = std::getenv("XDG_CACHE_HOME");
  int threads_ = omp_get_max_threads(), dynamic_ = omp_get_dynamic();
};

}  // namespace

Workshop::Outcome Workshop::forefeel(const std::string& arguments) const {
  std::vector<std::string> words = words_of(arguments);
  words.insert(words.begin(), executable());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const Surroundings surroundings(path_, (folder_ / "cache").string());
  const Streams streams;
  Outcome outcome;
  outcome.code = command_main(static_cast<int>(words.size()), argv.data());
  outcome.out = streams.text(STDOUT_FILENO);
  outcome.err = streams.text(STDERR_FILENO);
  flush_warnings();  // an error drops those that wait, and the next command must not print them
  return outcome;
}

Workshop::Outcome Workshop::run(const std::string& arguments) const {
  const Outcome outcome = forefeel(arguments);
  INFO("forefeel " << arguments << '\n' << outcome.err);
  REQUIRE(outcome.code == 0);
  return outcome;
}

nlohmann::json Workshop::json(const std::string& arguments) const {
  return run(arguments + " --json").json();
}

void check_refused(const Workshop& shop, const std::string& arguments,
                   const std::vector<std::string>& mentions) {
  const std::string before = shop.files();
  check_refused(shop.forefeel(arguments), arguments, mentions);
  CHECK(shop.files() == before);
}

}  // namespace forefeel::test
