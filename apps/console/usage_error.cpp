#include "apps/console/usage_error.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <string_view>

#include "apps/console/suggest.hpp"

namespace forefeel {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// A positional argument is named with its command: "solve: SCENE is missing".
InputError missing(const std::string& option, const std::string& program, const std::string& where) {
  if (option.starts_with("-")) return {option, fmt::format("is missing, see {} {} --help", program, where)};
  return {where, fmt::format("{} is missing, see {} {} --help", option, program, where)};
}

// "--seed: 1 required N missing", "--clock: At Most 1 required but received 2", or another form.
std::optional<InputError> wrong_count(const CLI::App& sub, const std::string& option,
                                      const std::string& problem) {
  const CLI::Option* known = sub.get_option_no_throw(option);
  const std::string type = known ? known->get_type_name() : "";
  if (problem.ends_with(" missing"))
    return InputError(option,
                      fmt::format("has no value, expected {} {}", option, type.substr(0, type.find(':'))));
  const std::size_t received = problem.find(" required but received ");
  if (received == std::string::npos) return {};
  const std::string given = problem.substr(received + 23), limit = problem.substr(0, received);
  if (limit == "At Most 1") return InputError(option, fmt::format("is given {} times, expected once", given));
  if (limit.starts_with("At least "))
    return InputError(option, fmt::format("has {} of its values, expected {}", given, limit.substr(9)));
  return {};
}

}  // namespace

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

// The first word must be a command. CLI11's own message would only say "unexpected argument".
void check_command(const CLI::App& app, const char* const* argv) {
  const std::vector<std::string> names = command_names(app);
  const std::string word = argv[1];
  if (word.starts_with("-") || std::ranges::find(names, word) != names.end()) return;
  throw InputError("command '" + word + "'", "unknown" + expected_instead(word, names));
}

// Mistyped options are found before parsing; otherwise their values would be read as positional arguments.
void check_options(const CLI::App& app, int argc, const char* const* argv) {
  const std::string first = argv[1];
  const CLI::App& chosen = first.starts_with("-") ? app : *app.get_subcommand(first);
  const std::vector<std::string> names = option_names(chosen);
  for (int i = 1; i < argc && argv[i] != std::string_view("--"); ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string_view(argv[i]).find('='));
    if (!word.starts_with("--") || std::ranges::find(names, word) != names.end()) continue;
    const std::string near = nearest_word(word, names);
    throw InputError(&chosen == &app ? "options" : first,
                     fmt::format("unknown option '{}'{} {} {}--help", word,
                                 near.empty() ? ", see" : fmt::format(", did you mean '{}'? See", near),
                                 app.get_name(), &chosen == &app ? "" : first + " "));
  }
}

// CLI11's messages as the others: place, what was given, what was expected.
InputError usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  const CLI::App& sub = chosen.empty() ? app : *chosen.front();
  const std::string where = chosen.empty() ? "options" : sub.get_name();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app.remaining(true).empty() && chosen.empty())
    return {where, fmt::format("unknown option '{0}', expected a command or --version, see {1} --help",
                               app.remaining(true).front(), app.get_name())};
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app.remaining(true).empty())
    return {where, fmt::format("unexpected argument '{}', see {} {} --help", app.remaining(true).front(),
                               app.get_name(), where)};
  const std::string text = error.what();
  const std::string conversion = "Could not convert: ";  // of a flag: values of options are checked before
  if (const std::size_t end = text.find(" = "); text.starts_with(conversion) && end != std::string::npos)
    return {text.substr(conversion.size(), end - conversion.size()),
            fmt::format("is '{}', expected no value", text.substr(end + 3))};
  const std::size_t colon = text.find(": ");
  if (dynamic_cast<const CLI::ValidationError*>(&error) && colon != std::string::npos)
    return {text.substr(0, colon), text.substr(colon + 2)};
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) && colon != std::string::npos)
    if (const auto found = wrong_count(sub, text.substr(0, colon), text.substr(colon + 2))) return *found;
  if (const std::size_t end = text.find(" is required"); dynamic_cast<const CLI::RequiredError*>(&error))
    if (end != std::string::npos) return missing(text.substr(0, end), app.get_name(), where);
  if (const std::size_t end = text.find(" excludes "); dynamic_cast<const CLI::ExcludesError*>(&error))
    if (end != std::string::npos)
      return {text.substr(0, end),
              fmt::format("is given with {}, expected one of the two", text.substr(end + 10))};
  return {where, fmt::format("{}, see {} {}--help", text, app.get_name(), chosen.empty() ? "" : where + " ")};
}

}  // namespace forefeel
