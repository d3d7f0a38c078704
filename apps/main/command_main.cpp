// The only place that catches every exception.

#include "apps/main/command_main.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <string_view>

#include "apps/console/commands.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/main/help_topics.hpp"
#include "apps/main/program.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/instruction_set.hpp"
#include "scheduling/study/study_run.hpp"

namespace forefeel {

int run_program(const Program& program, int argc, const char* const* argv) {
  remember_command(program.name, argc, argv);
  check_instruction_set();
  CommandLine line(program.name, program.description, version_text);
  for (const CommandGroup& group : program.groups) {
    line.begin_group(group.heading, group.example);
    for (const auto add : group.commands) add(line);
  }
  add_help(line, program);
  return line.run(argc, argv);
}

namespace {

// When interrupted, these commands stop by themselves and report what they keep.
bool watches(int argc, char** argv) {
  return argc > 1 && std::ranges::any_of(std::array{"session", "study", "generate"},
                                         [&](const char* name) { return argv[1] == std::string_view(name); });
}

bool has_word(int argc, char** argv, std::string_view wanted) {
  return std::any_of(argv, argv + argc, [&](const char* word) { return word == wanted; });
}

int tell_interrupted(const Program& program, const char* text, int argc, char** argv) {
  if (has_word(argc, argv, "--json")) std::cout << "{\n  \"interrupted\": true\n}\n";
  flush_warnings();
  std::cerr << program.name << ": " << text << '\n';
  return 1;
}

// If the reader of a pipe has ended, output is no longer wanted; that is not a failure.
bool reader_is_gone() {
  pollfd out{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

// Checks that the output was written completely. A full disk behind `> file` is detected here.
int printed(const Program& program, int code) {
  std::cout.flush();
  if (std::cout.good() && std::fflush(stdout) == 0) return code;
  if (reader_is_gone()) return code;
  std::cerr << program.name
            << ": stdout: cannot be written, so the results are incomplete (is the disk full?)\n";
  return code == 0 ? 1 : code;
}

int fail(const Program& program, const std::string& text, int code) {
  complain(program.name, text);
  return code;
}

}  // namespace

int program_main(const Program& program, int argc, char** argv) {
  write_errors_without_signals();
  // Under MPI rank 0 ends the others.
  if (watches(argc, argv))
    watch_from_the_start({.leave = !has_word(argc, argv, "--mpi"), .json = has_word(argc, argv, "--json")});
  try {
    return printed(program, run_program(program, argc, argv));
  } catch (const Interrupted& wish) {
    return tell_interrupted(program, wish.what(), argc, argv);
  } catch (const InputError& error) {
    return fail(program, error.what(), 2);
  } catch (const std::filesystem::filesystem_error& error) {
    // An InputError shortens long names.
    const std::string problem = error.code().message() + ", expected a file or folder that can be used";
    return fail(program, InputError({.file = error.path1().string()}, problem).what(), 2);
  } catch (const std::bad_alloc&) {
    return fail(program, "out of memory", 1);
  } catch (const StudyFailure& error) {
    return fail(program, error.what(), 1);
  } catch (const std::exception& error) {
    return fail(program, std::string("internal error: ") + error.what(), 1);
  }
}

const Program& forefeel_program() {
  static const Program program{
      .name = "forefeel",
      .description = "Haptic rendering of soft bodies from states solved ahead",
      .groups = {{"A body and its forces",
                  "forefeel mesh organ.obj --unit mm --elements 8000 -o organ.msh",
                  {add_mesh, add_solve, add_info, add_show}},
                 {"States, and where they make the force known",
                  "forefeel classify points.csv -o coverage.svg",
                  {add_generate, add_import, add_export, add_classify, add_evaluate}},
                 {"Sessions, in which a hand touches the body while workers solve",
                  "forefeel session apps/scenes/liver.toml -o run",
                  {add_session, add_replay, add_trace}},
                 {"Comparisons, and what else there is",
                  "forefeel study apps/studies/quick.toml -o study",
                  {add_study, add_reproduce, add_cache}}},
      .topics = help_topics};
  return program;
}

int command_main(int argc, char** argv) {
  return program_main(forefeel_program(), argc, argv);
}

}  // namespace forefeel
