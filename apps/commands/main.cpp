// forefeel <command> …: parses, runs the chosen command, and maps what happened to an exit code.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <string_view>

#include "approx/loops/instruction_set.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/console/provenance.hpp"
#include "apps/console/suggest.hpp"
#include "geometry/common/error.hpp"

namespace forefeel {
namespace {

void add_commands(CLI::App& app, Commands& commands) {
  for (const auto add : {add_mesh, add_solve, add_generate, add_import, add_export, add_info, add_classify,
                         add_evaluate, add_session, add_study, add_reproduce, add_bench})
    add(app, commands);
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

// The first word must be a command: said here, because CLI11 would only call it an unexpected argument.
void check_command(const CLI::App& app, int argc, const char* const* argv) {
  const std::vector<std::string> names = command_names(app);
  if (argc < 2) throw InputError("command", "none given, expected one of " + listed(names));
  const std::string word = argv[1];
  if (word.starts_with("-") || std::ranges::find(names, word) != names.end()) return;
  throw InputError("command '" + word + "'", fmt::format("unknown, did you mean '{}'? Expected one of {}",
                                                         nearest_word(word, names), listed(names)));
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// A mistyped option is found before parsing, or its value would pass for a positional argument.
void check_options(const CLI::App& app, int argc, const char* const* argv) {
  const std::string first = argv[1];
  const CLI::App& chosen = first.starts_with("-") ? app : *app.get_subcommand(first);
  const std::vector<std::string> names = option_names(chosen);
  for (int i = 1; i < argc && argv[i] != std::string_view("--"); ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (!word.starts_with("--") || std::ranges::find(names, word) != names.end()) continue;
    throw InputError(&chosen == &app ? "options" : first,
                     fmt::format("unknown option '{}', did you mean '{}'? See forefeel {}--help", word,
                                 nearest_word(word, names), &chosen == &app ? "" : first + " "));
  }
}

// CLI11 speaks in several lines and forms; this makes one line of it, with a suggestion for a mistyped
// option.
InputError usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  const CLI::App& sub = chosen.empty() ? app : *chosen.front();
  const std::string where = chosen.empty() ? "options" : sub.get_name();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app.remaining(true).empty())
    return {where, fmt::format("unexpected argument '{}', see forefeel {} --help",
                               app.remaining(true).front(), where)};
  std::string text = error.what();
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, "; ");
  while (text.ends_with("; ")) text.resize(text.size() - 2);
  return {where, text + fmt::format(" (see forefeel {}--help)", chosen.empty() ? "" : where + " ")};
}

// An empty value, of a shell variable that is not set, must not pass for an option that is not there.
void check_values(const CLI::App& app) {
  const auto check = [](const CLI::App& of) {
    for (const CLI::Option* option : of.get_options())
      if (std::ranges::any_of(option->results(), &std::string::empty))
        throw InputError(option->get_name(), "is empty, expected a value");
  };
  check(app);
  for (const CLI::App* sub : app.get_subcommands()) check(*sub);
}

int run(int argc, const char* const* argv) {
  remember_command(argc, argv);
  check_instruction_set();
  CLI::App app{"Haptic rendering of soft bodies from states solved ahead", "forefeel"};
  app.set_version_flag(
      "--version", [] { return version_text(); }, "Version, also of the libraries");
  Commands commands;
  add_commands(app, commands);
  app.require_subcommand(0, 1);
  check_command(app, argc, argv);
  check_options(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version
    return app.exit(done);
  } catch (const CLI::ParseError& error) {
    throw usage_error(app, error);
  }
  check_values(app);
  if (!commands.chosen)
    throw InputError("command", "none given, expected one of " + listed(command_names(app)));
  const int code = commands.chosen();
  flush_warnings();
  return code;
}

// These end of themselves when interrupted, and say what they keep.
bool watches(int argc, char** argv) {
  return argc > 1 && std::ranges::any_of(std::array{"session", "study", "generate"},
                                         [&](const char* name) { return argv[1] == std::string_view(name); });
}

int tell_interrupted(const char* text, int argc, char** argv) {
  if (std::any_of(argv, argv + argc, [](const char* word) { return word == std::string_view("--json"); }))
    std::cout << "{\n  \"interrupted\": true\n}\n";
  flush_warnings();
  std::cerr << "forefeel: " << text << '\n';
  return 1;
}

int complain(const std::string& text, int code) {
  std::cerr << "forefeel: " << text << '\n';
  return code;
}

}  // namespace
}  // namespace forefeel

int main(int argc, char** argv) {
  using namespace forefeel;
  if (watches(argc, argv)) watch_from_the_start();
  try {
    return run(argc, argv);
  } catch (const Interrupted& wish) {
    return tell_interrupted(wish.what(), argc, argv);
  } catch (const InputError& error) {
    return complain(error.what(), 2);
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(fmt::format("{}: {}", error.path1().string(), error.code().message()), 2);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", 1);
  } catch (const std::exception& error) {
    return complain(std::string("internal error: ") + error.what(), 1);
  }
}
