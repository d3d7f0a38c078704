#pragma once
// How the executable is put together: one file per subcommand, each with one add_…() that declares its options
// and what runs; main() parses, runs the chosen command and holds the only catch.
// Exit codes: 0 done; 1 ran, but the answer is negative or incomplete; 2 bad input.

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace forefeel {

struct Globals {
  bool json = false;  // one document on stdout, all else on stderr
  bool quiet = false;
  int threads = 0;  // 0: all cores
  std::uint64_t seed = 0;
  std::vector<std::string> set;  // --set key.path=value, overrides of the scene
};

struct Commands {
  Globals globals;
  std::function<int()> chosen;  // set by the subcommand that was given
};

// A subcommand with the global options attached; run is called after parsing, returns the exit code, and may throw
// InputError (exit 2).
CLI::App& add_command(CLI::App& app, Commands& commands, const std::string& name,
                      const std::string& description, std::function<int()> run);

void add_mesh(CLI::App& app, Commands& commands);    // command_mesh.cpp
void add_import(CLI::App& app, Commands& commands);  // command_states.cpp
void add_export(CLI::App& app, Commands& commands);
void add_info(CLI::App& app, Commands& commands);
void add_solve(CLI::App& app, Commands& commands);      // command_solve.cpp
void add_generate(CLI::App& app, Commands& commands);   // command_generate.cpp
void add_classify(CLI::App& app, Commands& commands);   // command_classify.cpp
void add_evaluate(CLI::App& app, Commands& commands);   // command_evaluate.cpp
void add_session(CLI::App& app, Commands& commands);    // command_session.cpp
void add_study(CLI::App& app, Commands& commands);      // command_study.cpp
void add_reproduce(CLI::App& app, Commands& commands);  // command_reproduce.cpp
void add_bench(CLI::App& app, Commands& commands);      // command_bench.cpp, which calls those below
int bench_coverage(const Globals& globals);             // bench_coverage.cpp
// bench_solver.cpp; most_states: 0 for the scene's whole lattice
int bench_solver(const Globals& globals, const std::string& scene, std::size_t most_states);
int bench_approx(const Globals& globals, const std::string& scene,
                 const std::string& folder);                         // bench_approx.cpp
int bench_switch(const Globals& globals, const std::string& scene);  // bench_switch.cpp

// Parsing and printing shared by the commands.
nlohmann::ordered_json number(double value);  // null where not finite
nlohmann::ordered_json vector3(const Eigen::Ref<const Eigen::Vector3d>& value);
void print_json(const nlohmann::ordered_json& document);  // stdout
void say(const Globals& globals,
         const std::string& line);  // a line for people: stdout, stderr with --json, silent with --quiet
void answer(const Globals& globals, const std::string& line);  // a result: as say(), but --quiet shows it too
// stderr: "forefeel: warning: …", held back until the command shows something else or ends well, so that an input
// error that follows stays the only line.
void warn(const Globals& globals, const std::string& line);
void flush_warnings();
// For numbers on the command line; NaN is refused too.
std::string above_zero(const std::string& text);
std::string zero_or_more(const std::string& text);
Eigen::Vector3d parse_vector(const std::string& text, const std::string& where);  // "X,Y,Z", finite

// One progress line on stderr, redrawn at most 10 times a second and only on a terminal; silent otherwise.
class Progress {
 public:
  Progress(const Globals& globals, std::string title);
  ~Progress();                                       // clears the line
  void show(double share, const std::string& text);  // remaining time is worked out from share in [0, 1]

 private:
  bool live_;
  std::string title_;
  std::int64_t started_ns_ = 0, shown_ns_ = 0;
};

}  // namespace forefeel
