#include "apps/console/command.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <map>
#include <optional>
#include <string_view>
#include <type_traits>

#include "apps/console/grouped_help.hpp"
#include "apps/console/suggest.hpp"
#include "apps/console/usage_error.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/threads.hpp"

namespace forefeel {

// ---- checks of values ----
// A refusal continues the option's name: "--seed: is '1.5', expected a whole number".

namespace {

using Refusal = std::function<std::string(const std::string&)>;

template <class Number>
bool reads_as(const std::string& text, Number& number) {
  return CLI::detail::lexical_cast(text, number);
}

template <class Number>
CLI::Validator range(Number low, Number high) {
  const std::string words = fmt::format("{} to {}", low, high);
  const Refusal refusal = [low, high, words](const std::string& text) {
    Number number{};
    const bool fits = reads_as(text, number) && number >= low && number <= high;
    return fits ? std::string() : fmt::format("is {}, expected {}", text, words);
  };
  return {refusal, words};
}

// What a value must be, for variables that are not text.
template <class Number>
void check_type(CLI::Option* option) {
  option->check([](const std::string& text) {
    Number number{};
    if (reads_as(text, number)) return std::string();
    return fmt::format("{}, expected a {}number{}", text.empty() ? "is empty" : fmt::format("is '{}'", text),
                       std::is_integral_v<Number> ? "whole " : "",
                       std::is_unsigned_v<Number> ? " of at least 0" : "");
  });
}

template <class Value>
struct NumberIn {
  using Type = void;  // text
};
template <class Number>
requires std::is_arithmetic_v<Number>
struct NumberIn<Number> {
  using Type = Number;
};
template <class Value>
struct NumberIn<std::optional<Value>> : NumberIn<Value> {};
template <class Value>
struct NumberIn<std::vector<Value>> : NumberIn<Value> {};

}  // namespace

// ---- one option ----

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::shows(const std::string& value) {
  option_->type_name(value);
  return *this;
}

Option& Option::shows_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::group(const std::string& heading) {
  option_->group(heading);
  return *this;
}

Option& Option::check(const std::function<std::string(const std::string&)>& refusal) {
  option_->check(refusal);
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  const Refusal refusal = [words](const std::string& text) {
    const bool known = std::ranges::find(words, text) != words.end();
    return known ? std::string() : fmt::format("is '{}'{}", text, expected_instead(text, words));
  };
  option_->check(CLI::Validator(refusal, fmt::format("{{{}}}", fmt::join(words, ","))));
  return *this;
}

Option& Option::between(int low, int high) {
  option_->check(range(low, high));
  return *this;
}

Option& Option::between(double low, double high) {
  option_->check(range(low, high));
  return *this;
}

Option& Option::between(std::size_t low, std::size_t high) {
  option_->check(range(low, high));
  return *this;
}

Option& Option::takes(int values) {
  option_->expected(values);
  return *this;
}

Option& Option::takes_one() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::splits_at(char delimiter) {
  option_->delimiter(delimiter);
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

// ---- one command ----

template <class Value>
Option Command::option(const std::string& names, Value& variable, const std::string& help) {
  CLI::Option* option = app_->add_option(names, variable, help);
  using Number = typename NumberIn<Value>::Type;
  if constexpr (!std::is_void_v<Number>) check_type<Number>(option);
  return Option(option);
}

using std::optional, std::string, std::vector;
template Option Command::option(const string&, string&, const string&);
template Option Command::option(const string&, double&, const string&);
template Option Command::option(const string&, int&, const string&);
template Option Command::option(const string&, std::size_t&, const string&);
template Option Command::option(const string&, optional<string>&, const string&);
template Option Command::option(const string&, optional<double>&, const string&);
template Option Command::option(const string&, optional<int>&, const string&);
template Option Command::option(const string&, optional<std::size_t>&, const string&);
template Option Command::option(const string&, optional<long long>&, const string&);
template Option Command::option(const string&, vector<string>&, const string&);
template Option Command::option(const string&, vector<int>&, const string&);

Option Command::flag(const std::string& names, bool& variable, const std::string& help) {
  return Option(app_->add_flag(names, variable, help));
}

bool Command::given(const std::string& name) const {
  return app_->count(name) > 0;
}

void Command::reads_no_scene() {
  CLI::Option* set = app_->get_option("--set");
  set->description("For commands that read a scene; refused here");
  set->check([name = app_->get_name()](const std::string&) {
    return fmt::format("is about keys of a scene, but {} reads none, expected no --set", name);
  });
}

// ---- options that all commands share ----

namespace {

// Refuses an empty value: it usually comes from an unset shell variable and must not look like a missing
// option.
void check_values(const CLI::App& app) {
  const auto check = [](const CLI::App& of) {
    for (const CLI::Option* option : of.get_options())
      if (std::ranges::any_of(option->results(), &std::string::empty))
        throw InputError(option->get_name(), "is empty, expected a value");
  };
  check(app);
  for (const CLI::App* sub : app.get_subcommands()) check(*sub);
}

std::string refuse_seed(const std::string& text) {
  std::uint64_t seed = 0;
  errno = 0;
  std::strtoull(text.c_str(), nullptr, 0);
  const bool fits = errno == 0 && !text.starts_with('-') && reads_as(text, seed);
  return fits ? std::string() : "is '" + text + "', expected a whole number of at least 0, below 2^64";
}

// False in the other processes of mpirun, whose lines would come between.
bool is_first_rank() {
  for (const char* variable : {"OMPI_COMM_WORLD_RANK", "PMI_RANK"})
    if (const char* rank = std::getenv(variable)) return rank == std::string_view("0");
  return true;
}

void add_shared_options(CLI::App& sub, Globals& globals) {
  sub.option_defaults()->always_capture_default(false);
  const char* const heading = "Everywhere";
  sub.add_flag("--json", globals.json, "One JSON document on stdout, everything else on stderr")
      ->group(heading);
  sub.add_flag("--quiet", globals.quiet, "Nothing but results, warnings and errors")->group(heading);
  sub.add_option("--threads", globals.threads, "Threads; 0: all cores")
      ->check(range(0, 4096))
      ->type_name("N")
      ->group(heading);
  sub.add_option("--seed", globals.seed, "Seed of everything random")
      ->check(refuse_seed)
      ->type_name("N")
      ->group(heading);
  sub.add_option("--set", globals.set, "Override a key of the scene: material.poisson=0.4; may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY.PATH=VALUE")
      ->group(heading);
}

}  // namespace

// ---- the command line ----

struct CommandLine::Parser {
  CLI::App app;
  Globals globals;
  std::map<std::string, std::string> examples;          // by the heading of a group
  std::string group;                                    // of the commands added next
  std::deque<std::function<int(const Globals&)>> runs;  // one per command; a deque keeps references valid
  const std::function<int(const Globals&)>* chosen = nullptr;  // function of the chosen command
  Parser(const std::string& description, const std::string& name) : app(description, name) {}
};

CommandLine::CommandLine(const std::string& program, const std::string& description,
                         std::function<std::string()> version)
    : parser_(std::make_unique<Parser>(description, program)) {
  parser_->app.set_version_flag("--version", std::move(version), "Version, also of the libraries");
  parser_->app.require_subcommand(0, 1);
  parser_->app.formatter(grouped_help(parser_->examples));
}

CommandLine::~CommandLine() = default;

void CommandLine::begin_group(const std::string& heading, const std::string& example) {
  parser_->group = heading;
  parser_->examples[heading] = example;
}

Command CommandLine::add(const std::string& name, const std::string& description) {
  CLI::App& sub = *parser_->app.add_subcommand(name, description);
  if (!parser_->group.empty()) sub.group(parser_->group);
  add_shared_options(sub, parser_->globals);
  std::function<int(const Globals&)>& run = parser_->runs.emplace_back();
  sub.callback([parser = parser_.get(), &run] { parser->chosen = &run; });
  return Command(&sub, &run);
}

namespace {

// Commands that refuse more threads than `most` for their memory have their own error.
void check_threads(int threads) {
  constexpr int most = 4096;
  const int tried = std::min(threads, most);
  if (tried <= 1) return;
  if (const int start = threads_that_start(tried); start < tried)
    throw InputError(
        "--threads",
        fmt::format("is {}, and the limits of this process or of its memory (ulimit -u, -v) allow "
                    "{}, expected at most so many",
                    threads, start));
}

}  // namespace

std::vector<std::string> CommandLine::commands() const {
  return command_names(parser_->app);
}

int CommandLine::run(int argc, const char* const* argv) {
  CLI::App& app = parser_->app;
  const bool version = argc == 2 && argv[1] == std::string_view("version");
  const char* const said[] = {argv[0], version ? "--version" : "--help"};
  if (argc < 2 || version) return run(2, said);
  check_command(app, argv);
  check_options(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {  // --help, --version
    return app.exit(done);
  } catch (const CLI::ParseError& error) {
    throw usage_error(app, error);
  }
  check_values(app);
  if (!parser_->chosen)
    throw InputError("command", "none given, expected one of " + listed(command_names(app)));
  const Globals& globals = parser_->globals;
  check_threads(globals.threads);
  if (globals.threads > 0) omp_set_num_threads(globals.threads);
  std::optional<Progress> line;  // of what shows nothing itself
  if (is_first_rank()) line.emplace(globals, app.get_subcommands().front()->get_name());
  const int code = (*parser_->chosen)(globals);
  line.reset();
  flush_warnings();
  return code;
}

}  // namespace forefeel
