#pragma once
// Flaws of recorded motions that are valid numbers.
//
// Lost samples: many trackers write 0, 0, 0 while they do not see their tool. A run of rows at exactly zero
// counts as lost if every row beside it lies farther than lost_jump from zero, and farther than lost_steps median
// steps of the other rows. A motion that passes through zero, or rests there, keeps its rows.
//
// Matrices: a pose written as a 4 x 4 matrix takes four lines, the last of them 0 0 0 1. Such lines are not
// samples of a motion.

#include <cstddef>
#include <vector>

#include "scheduling/motion/trace_cells.hpp"
#include "scheduling/motion/trace_file.hpp"

namespace forefeel {

constexpr double lost_jump = 0.01;  // [m]
constexpr double lost_steps = 20;

// Indices of the lost rows, ascending.
std::vector<std::size_t> lost_rows(const TraceRows& rows);
void leave_out(TraceRows& rows, const std::vector<std::size_t>& lost);

// True if all rows from `first` on have four numbers and every fourth of these rows is 0 0 0 1.
bool are_matrices(const std::vector<TraceRow>& rows, std::size_t first);

}  // namespace forefeel
