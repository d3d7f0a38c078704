#pragma once
// What the programs forefeel and forefeel-bench share: a command line of commands and `help`, and the only place that
// catches every exception.

#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/main/help_topics.hpp"

namespace forefeel {

// Commands that help lists together, and a command line that shows one of them in use.
struct CommandGroup {
  std::string heading, example;
  std::vector<void (*)(CommandLine&)> commands;
};

struct Program {
  std::string name, description;
  std::vector<CommandGroup> groups;    // `help` stands in the last one
  std::vector<HelpTopic> (*topics)();  // of `help`
};
const Program& forefeel_program();

// Parses, runs the chosen command and returns its exit code. Throws what the command throws.
int run_program(const Program& program, int argc, const char* const* argv);
// The same for main(): prints errors and turns them into exit codes, as command_main() (command_main.hpp).
int program_main(const Program& program, int argc, char** argv);

// `help [TOPIC [TABLE]]` of a program.
void add_help(CommandLine& line, const Program& program);

}  // namespace forefeel
