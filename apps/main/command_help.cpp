// forefeel help [TOPIC [TABLE]] [-o OUT.html]: the reference of keys, settings and columns.

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
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

// A topic with the tables of one name, or with the rows of one key: "session", "spacing", "session.policy".
std::optional<HelpTopic> narrowed(const HelpTopic& topic, const std::string& name) {
  if (std::vector<DeclaredTable> tables = tables_named(topic, name); !tables.empty())
    return HelpTopic{topic.name, topic.meaning, std::move(tables)};
  HelpTopic found{topic.name, topic.meaning, {}};
  for (const DeclaredTable& table : topic.tables) {
    DeclaredTable rows{table.name, table.meaning, {}};
    std::ranges::copy_if(table.rows, std::back_inserter(rows.rows), [&](const Declared& row) {
      return row.name == name || table.name + "." + row.name == name;
    });
    if (!rows.rows.empty()) found.tables.push_back(std::move(rows));
  }
  return found.tables.empty() ? std::nullopt : std::optional(std::move(found));
}

// A word that is no topic: the tables and keys of this name, wherever they are. Of a command there may be none.
std::vector<HelpTopic> looked_up(const Program& program, const std::vector<HelpTopic>& topics,
                                 const std::string& word, bool command) {
  std::vector<HelpTopic> found;
  std::vector<std::string> names;
  for (const HelpTopic& topic : topics) {
    names.push_back(topic.name);
    if (std::optional<HelpTopic> part = narrowed(topic, word)) found.push_back(std::move(*part));
  }
  if (found.empty() && !command)
    throw InputError("help '" + word + "'", "unknown topic" + expected_instead(word, names) +
                                                ", or a table or key of one of them; the "
                                                "options of a command: " +
                                                program.name + " COMMAND --help");
  return found;
}

// What was asked for. InputError for an unknown topic or table.
std::vector<HelpTopic> chosen(const Program& program, const HelpArguments& arguments, bool command) {
  std::vector<HelpTopic> topics = program.topics();
  if (arguments.topic.empty()) return topics;
  const auto alias = help_aliases().find(arguments.topic);
  const std::string name = alias == help_aliases().end() ? arguments.topic : alias->second;
  const auto found = std::ranges::find(topics, name, &HelpTopic::name);
  if (found == topics.end()) return looked_up(program, topics, arguments.topic, command);
  if (arguments.table.empty()) return {*found};
  if (std::optional<HelpTopic> part = narrowed(*found, arguments.table)) return {std::move(*part)};
  std::vector<std::string> names;
  for (const DeclaredTable& table : found->tables) names.push_back(table.name);
  throw InputError(fmt::format("help {} '{}'", found->name, arguments.table),
                   "unknown table" + expected_instead(arguments.table, names));
}

void list_topics(const Globals& globals, const Program& program, const std::vector<HelpTopic>& topics) {
  for (const HelpTopic& topic : topics) {
    std::vector<std::string> names;
    for (const DeclaredTable& table : topic.tables) names.push_back(table.name);
    answer(globals, fmt::format("{} help {}\n  {}{}{}", program.name, topic.name, topic.meaning,
                                names.empty() ? "" : "\n  ", listed(names)));
  }
  answer(globals,
         fmt::format("{0} help TOPIC TABLE: one table. {0} COMMAND --help: the options of a command.",
                     program.name));
}

int run_help(const Globals& globals, const Program& program, const HelpArguments& arguments,
             const std::vector<std::string>& commands) {
  const bool command = std::ranges::find(commands, arguments.topic) != commands.end();
  const std::vector<HelpTopic> topics = chosen(program, arguments, command);
  if (!arguments.output.empty()) {
    if (std::filesystem::path(arguments.output).extension() != ".html")
      throw InputError("-o " + arguments.output, "expected a file OUT.html");
    write_whole(arguments.output, as_html(program.name, topics));
  }
  if (globals.json) return print_json(to_json(topics)), 0;
  if (!arguments.output.empty()) return say(globals, arguments.output), 0;
  if (arguments.topic.empty()) return list_topics(globals, program, topics), 0;
  std::string text;
  const auto named = [&](const HelpTopic& topic) { return topic.name == arguments.topic; };
  const bool whole = std::ranges::any_of(topics, named) && arguments.table.empty();
  if (whole)
    text = (topics.front().page.empty() ? topics.front().meaning + "\n" : std::string(topics.front().page)) +
           "\n";
  for (const HelpTopic& topic : topics) {
    if (!whole && arguments.table.empty()) text += fmt::format("{} help {}:\n", program.name, topic.name);
    for (const DeclaredTable& table : topic.tables) text += as_text(table, terminal_width()) + "\n";
  }
  if (command) text += fmt::format("Options of the command: {} {} --help\n", program.name, arguments.topic);
  while (text.ends_with('\n')) text.pop_back();
  answer(globals, text);
  return 0;
}

}  // namespace

void add_help(CommandLine& line, const Program& program) {
  const auto arguments = std::make_shared<HelpArguments>();
  std::vector<std::string> names;
  for (const HelpTopic& topic : program.topics()) names.push_back(topic.name);
  Command sub = line.add("help", "The guide, and every key, setting and column of what is read and written");
  sub.runs([arguments, &program, &line](const Globals& globals) {
    return run_help(globals, program, *arguments, line.commands());
  });
  sub.option("TOPIC", arguments->topic, fmt::format("{}; without it, the topics are listed", listed(names)));
  sub.option("TABLE", arguments->table,
             fmt::format("One table of the topic: {} help TOPIC TABLE", program.name));
  sub.option("-o,--output", arguments->output, "The same as a page").shows("OUT.html");
}

}  // namespace forefeel
