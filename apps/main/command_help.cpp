// forefeel help [TOPIC [TABLE]] [-o OUT.html]: the reference of keys, settings and columns.

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/console/json.hpp"
#include "apps/console/suggest.hpp"
#include "apps/main/help_topics.hpp"
#include "apps/main/program.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/output_file.hpp"

namespace forefeel {
namespace {

struct HelpArguments {
  std::string topic, table, output;
};

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 60) return 100;
  return std::min<std::size_t>(size.ws_col, 120);
}

// What was asked for. InputError for an unknown topic or table.
std::vector<HelpTopic> chosen(const Program& program, const HelpArguments& arguments) {
  std::vector<HelpTopic> topics = program.topics();
  if (arguments.topic.empty()) return topics;
  std::vector<std::string> names;
  for (const HelpTopic& topic : topics) names.push_back(topic.name);
  const auto found = std::ranges::find(topics, arguments.topic, &HelpTopic::name);
  if (found == topics.end())
    throw InputError("help '" + arguments.topic + "'",
                     "unknown topic" + expected_instead(arguments.topic, names) +
                         "; the options of a command: " + program.name + " COMMAND --help");
  if (arguments.table.empty()) return {*found};
  std::vector<DeclaredTable> tables = tables_named(*found, arguments.table);
  if (tables.empty()) {
    names.clear();
    for (const DeclaredTable& table : found->tables) names.push_back(table.name);
    throw InputError(fmt::format("help {} '{}'", found->name, arguments.table),
                     "unknown table" + expected_instead(arguments.table, names));
  }
  found->tables = std::move(tables);
  return {*found};
}

void list_topics(const Globals& globals, const Program& program, const std::vector<HelpTopic>& topics) {
  for (const HelpTopic& topic : topics) {
    std::vector<std::string> names;
    for (const DeclaredTable& table : topic.tables) names.push_back(table.name);
    answer(globals,
           fmt::format("{} help {}\n  {}\n  {}", program.name, topic.name, topic.meaning, listed(names)));
  }
  answer(globals,
         fmt::format("{0} help TOPIC TABLE: one table. {0} COMMAND --help: the options of a command.",
                     program.name));
}

int run_help(const Globals& globals, const Program& program, const HelpArguments& arguments) {
  const std::vector<HelpTopic> topics = chosen(program, arguments);
  if (!arguments.output.empty()) {
    if (std::filesystem::path(arguments.output).extension() != ".html")
      throw InputError("-o " + arguments.output, "expected a file OUT.html");
    write_whole(arguments.output, as_html(program.name, topics));
  }
  if (globals.json) return print_json(to_json(topics)), 0;
  if (!arguments.output.empty()) return say(globals, arguments.output), 0;
  if (arguments.topic.empty()) return list_topics(globals, program, topics), 0;
  std::string text;
  if (arguments.table.empty()) text = topics.front().meaning + "\n\n";
  for (const DeclaredTable& table : topics.front().tables) text += as_text(table, terminal_width()) + "\n";
  while (text.ends_with('\n')) text.pop_back();
  answer(globals, text);
  return 0;
}

}  // namespace

void add_help(CommandLine& line, const Program& program) {
  const auto arguments = std::make_shared<HelpArguments>();
  std::vector<std::string> names;
  for (const HelpTopic& topic : program.topics()) names.push_back(topic.name);
  Command sub = line.add("help", "Every key, setting and column of what is read and written");
  sub.runs([arguments, &program](const Globals& globals) { return run_help(globals, program, *arguments); });
  sub.option("TOPIC", arguments->topic, fmt::format("{}; without it, the topics are listed", listed(names)));
  sub.option("TABLE", arguments->table,
             fmt::format("One table of the topic: {} help TOPIC TABLE", program.name));
  sub.option("-o,--output", arguments->output, "The same as a page").shows("OUT.html");
}

}  // namespace forefeel
