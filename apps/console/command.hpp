#pragma once
// The command line: `forefeel <command> …` and `forefeel-bench <command> …`. A command has a name, options and a
// function to run. Each is in a file command_NAME.cpp of its room in apps. Only command.cpp includes the parser, CLI11.
//
//   Command solve = line.add("solve", "Tight solves …");
//   solve.option("SCENE", arguments->scene, "Scene (TOML)").required();
//   solve.runs([arguments](const Globals& globals) { return run_solve(globals, *arguments); });
//
// Exit codes: 0 done; 1 ran, but the answer is negative or incomplete; 2 bad input.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/console/console.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace forefeel {

// One option or positional argument. Calls can be chained. It lives as long as its command line.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required();
  Option& shows(const std::string& value);  // name of the value in --help: "H", "OUT.csv"
  Option& shows_default();                  // --help shows the current value of the variable
  Option& group(const std::string& heading);
  // A check returns an empty text if the value is valid, else the error ("is x, expected …").
  Option& check(const std::function<std::string(const std::string&)>& refusal);
  Option& one_of(const std::vector<std::string>& words);
  Option& between(int low, int high);  // bounds included, also below
  Option& between(double low, double high);
  Option& between(std::size_t low, std::size_t high);
  Option& takes(int values);  // exactly this many values each time the option is given
  Option& takes_one();        // for a list: one value each time, so that the next word is not read as a value
  Option& splits_at(char delimiter);
  Option& excludes(const Option& other);

 private:
  CLI::Option* option_;
};

// A subcommand. It lives as long as its command line.
class Command {
 public:
  explicit Command(CLI::App* app, std::function<int(const Globals&)>* run) : app_(app), run_(run) {}

  // names: "-o,--output", or "SCENE" for a positional argument. The variable must outlive the command line.
  // Variables: std::string, double, int, std::size_t; std::optional of these and of long long; std::vector of
  // std::string and int.
  template <class Value>
  Option option(const std::string& names, Value& variable, const std::string& help);
  Option flag(const std::string& names, bool& variable, const std::string& help);
  // Called after parsing; returns the exit code and may throw InputError (exit 2).
  void runs(std::function<int(const Globals&)> run) { *run_ = std::move(run); }

  // The command refuses --set.
  void reads_no_scene();

  bool given(
      const std::string& name) const;  // true if the option was on the command line; call after parsing

 private:
  CLI::App* app_;
  std::function<int(const Globals&)>* run_;
};

class CommandLine {
 public:
  // program: its name, as one types it; version: the text of --version.
  CommandLine(const std::string& program, const std::string& description,
              std::function<std::string()> version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  // Heading of the commands that are added from here on, and a command line that shows one of them in use.
  void begin_group(const std::string& heading, const std::string& example);
  // Adds a subcommand. It already has the options that all commands share.
  Command add(const std::string& name, const std::string& description);
  std::vector<std::string> commands() const;  // their names
  // Parses, runs the chosen command and returns its exit code; --help, --version, `version` and no word at all print
  // and return 0.
  // Throws InputError for a bad command line: one line, with a suggestion for a mistyped word.
  int run(int argc, const char* const* argv);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace forefeel
