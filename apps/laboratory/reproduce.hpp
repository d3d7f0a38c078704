#pragma once
// The experiments of `forefeel reproduce`. Each runs in a laboratory, writes its table and pictures into a
// folder, and returns its part of the report and of the summary. To add one, write a function and add a line
// to experiments().

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/scene/laboratory.hpp"

namespace forefeel {

struct ReproduceOptions {
  std::size_t depth = 10;   // length of the path in spacings (paper: 6 cm at 6 mm)
  std::size_t gap = 8;      // width of the gap, at most depth - 2
  double interval = 10;     // between groups of states [s] (paper: 10 s)
  std::size_t rounds = 60;  // timed repetitions
  double travel = 5;  // path length of each run of `speed` [m]: the lines cover the default box about once
  std::vector<int> workers{2, 4, 16, 64};  // worker counts of `speed`
  int seeds = 1;                           // number of seeds of `speed`: 1, 2, …
};

struct Findings {
  nlohmann::ordered_json summary;
  std::string html;                     // paragraphs, tables, figures; without a heading
  std::vector<std::string> lines;       // for the terminal
  std::vector<std::string> unmet = {};  // claims about our settings that do not hold; any gives exit code 1
};

struct Experiment {
  std::string name, title;
  Findings (*run)(Laboratory&, const ReproduceOptions&, const std::filesystem::path&, const ShowShare&);
};

Findings reproduce_timing(Laboratory&, const ReproduceOptions&, const std::filesystem::path&,
                          const ShowShare&);
Findings reproduce_extrapolation(Laboratory&, const ReproduceOptions&, const std::filesystem::path&,
                                 const ShowShare&);
Findings reproduce_damping(Laboratory&, const ReproduceOptions&, const std::filesystem::path&,
                           const ShowShare&);
Findings reproduce_energy(Laboratory&, const ReproduceOptions&, const std::filesystem::path&,
                          const ShowShare&);

Findings reproduce_speed(Laboratory&, const ReproduceOptions&, const std::filesystem::path&,
                         const ShowShare&);
// Throws InputError if --set changes a key that the steps of `speed` change.
void check_speed_overrides(const Globals& globals);
// Throws InputError if a cell of `speed` cannot run. Writes nothing.
void check_speed(const Laboratory& laboratory, const ReproduceOptions& options);

const std::vector<Experiment>& experiments();  // in the order of the report

// "3.2 %", or a dash if unknown.
std::string percent(double share);
// An HTML paragraph. Escapes the text.
std::string paragraph(const std::string& lead, const std::string& text);

}  // namespace forefeel
