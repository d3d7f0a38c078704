#pragma once
// The experiments of `forefeel reproduce`: each runs in a laboratory, writes its table and pictures into a
// folder and returns what goes into the report and the summary. A new one is a function and a line in
// experiments().

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/laboratory/laboratory.hpp"

namespace forefeel {

struct ReproduceOptions {
  std::size_t depth = 10;   // length of the path in spacings (paper: 6 cm at 6 mm)
  std::size_t gap = 8;      // width of the gap, at most depth - 2
  double interval = 10;     // between groups of states [s] (paper: 10 s)
  std::size_t rounds = 60;  // timed repetitions
  double travel = 5;        // of each run of `speed` [m]: about one pass of the lines over the default box
  std::vector<int> workers{2, 4, 16, 64};  // of `speed`
  int seeds = 1;                           // of `speed`, from 1 on
};

struct Findings {
  nlohmann::ordered_json summary;
  std::string html;                     // paragraphs, tables, figures; without a heading
  std::vector<std::string> lines;       // for the terminal
  std::vector<std::string> unmet = {};  // what should hold with our settings and does not: exit 1
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
// InputError where --set gives what the steps of `speed` change.
void check_speed_overrides(const Globals& globals);
// InputError where a cell of `speed` cannot be run; nothing is written.
void check_speed(const Laboratory& laboratory, const ReproduceOptions& options);

const std::vector<Experiment>& experiments();  // in the order of the report

// "3.2 %", or a dash where it is not known.
std::string percent(double share);
// A paragraph of text; what is given is escaped.
std::string paragraph(const std::string& lead, const std::string& text);

}  // namespace forefeel
