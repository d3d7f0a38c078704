#pragma once
// The subcommands of forefeel. Each function adds its command to the command line. Most are in a file
// command_NAME.cpp of their own.

#include "apps/console/command.hpp"

namespace forefeel {

void add_mesh(CommandLine& line);
void add_import(CommandLine& line);  // import and export are in command_states.cpp
void add_export(CommandLine& line);
void add_info(CommandLine& line);
void add_solve(CommandLine& line);
void add_generate(CommandLine& line);
void add_classify(CommandLine& line);
void add_evaluate(CommandLine& line);
void add_session(CommandLine& line);
void add_replay(CommandLine& line);
void add_study(CommandLine& line);
void add_reproduce(CommandLine& line);
void add_cache(CommandLine& line);
void add_show(CommandLine& line);
void add_trace(CommandLine& line);

}  // namespace forefeel
