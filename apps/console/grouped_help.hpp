#pragma once
// The text of --help: commands under the headings of their groups, each with its first sentence, and each group with an
// example.

#include <map>
#include <memory>
#include <string>

namespace CLI {
class FormatterBase;
}  // namespace CLI

namespace forefeel {

// examples: a command line by heading, which must outlive the result.
std::shared_ptr<CLI::FormatterBase> grouped_help(const std::map<std::string, std::string>& examples);

}  // namespace forefeel
