#pragma once
// A study runs a session under the virtual clock for every combination of its axes and every seed.
//
//   Study study{.seeds = {1, 2, 3}, .axes = {{"policy", {{"nearest"}, {"coverage"}}}}};
//   StudyPlan plan = plan_study(study, [&](std::span<const std::size_t> choice) {   // study_plan.hpp
//     StudySession session = mine;
//     session.options.planning.policy = choice[0] == 0 ? "nearest" : "coverage";
//     return session;
//   });
//   StudyResult result = run_study(plan, {});                                       // study_run.hpp
//   std::vector<AxisRanking> ranked = rankings(study, result.cells);                // study_ranking.hpp
//
// Cells are numbered: the first axis varies slowest, the seed fastest.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace forefeel {

struct StudyValue {
  std::string text;                   // as printed in tables
  std::optional<double> number = {};  // of the axes `target_load` and `speed`
};

// The study itself interprets three columns: `target_load` [1] (load: utilisation of the workers) sets the cost of
// solves, `speed` [m/s] sets the speed of a path device, and `step` means that each value adds to the one before. The
// caller interprets all others when it makes the sessions (StudySessions in study_plan.hpp).
struct StudyAxis {
  std::string column;
  std::vector<StudyValue> values;
};

// Each cell searches for the highest speed that it sustains (sustained_speed.hpp).
struct SustainedOptions {
  double travel = 0.6;             // length of each run [m]; it takes travel / speed
  double share = 0.95;             // of first-visit frames that must be within the tolerance
  double tolerance = 0.07;         // of the reference force
  double low = 0.005, high = 2.0;  // speeds tried [m/s]
};

struct Study {
  std::vector<std::uint64_t> seeds = {0};
  std::vector<StudyAxis> axes = {};
  std::optional<std::size_t> baseline = {};  // value of axes[0] that the others are compared with
  std::optional<SustainedOptions> sustained = {};

  std::size_t combinations() const;  // without seeds
  std::size_t cells() const { return combinations() * seeds.size(); }
  // Value of each axis in a combination.
  std::vector<std::size_t> choice(std::size_t combination) const;
  std::size_t combination_of(std::size_t cell) const { return cell / seeds.size(); }
  std::uint64_t seed_of(std::size_t cell) const { return seeds[cell % seeds.size()]; }
};

// Number of the axis with this column.
std::optional<std::size_t> find_axis(const Study& study, std::string_view column);
// Value of the axis with this column in a combination; nullopt if there is no such axis.
std::optional<double> number_at(const Study& study, const std::vector<std::size_t>& choice,
                                std::string_view column);
// Whether the values of the axis are traces (column `device`). Traces are the groups of the statistics.
bool is_trace_axis(const StudyAxis& axis);

// Block of each cell: cells that differ only in this axis share a block. Blocks are numbered from 0 in order
// of appearance.
std::vector<std::size_t> blocks_without(const Study& study, std::size_t axis);

}  // namespace forefeel
