#pragma once
// Errors of a command line, as those of files: one line with the place, what was given and what was expected.

#include <string>
#include <vector>

#include "geometry/common/error.hpp"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace forefeel {

std::vector<std::string> command_names(const CLI::App& app);
// InputError unless the first word is a command or an option.
void check_command(const CLI::App& app, const char* const* argv);
// InputError for a mistyped option. Called before parsing, which would read its value as a positional argument.
void check_options(const CLI::App& app, int argc, const char* const* argv);
// The parser's own error in these words.
InputError usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace forefeel
