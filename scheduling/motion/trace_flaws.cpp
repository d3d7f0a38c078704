#include "scheduling/motion/trace_flaws.hpp"

#include <algorithm>
#include <utility>

#include "geometry/common/quantiles.hpp"

namespace forefeel {
namespace {

// The median step between neighbouring rows that are not at zero [m].
double usual_step(const TraceRows& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.positions.size(); ++i)
    if (!rows.positions[i].isZero(0) && !rows.positions[i - 1].isZero(0))
      steps.push_back((rows.positions[i] - rows.positions[i - 1]).norm());
  return steps.empty() ? 0 : median(steps);
}

}  // namespace

std::vector<std::size_t> lost_rows(const TraceRows& rows) {
  std::vector<std::size_t> lost;
  const std::size_t n = rows.positions.size();
  const double jump = std::max(lost_jump, lost_steps * usual_step(rows));
  for (std::size_t begin = 0; begin < n; ++begin) {
    if (!rows.positions[begin].isZero(0)) continue;
    std::size_t end = begin;
    while (end < n && rows.positions[end].isZero(0)) ++end;
    const bool far_before = begin == 0 || rows.positions[begin - 1].norm() > jump;
    const bool far_after = end == n || rows.positions[end].norm() > jump;
    const bool all = begin == 0 && end == n;
    for (std::size_t i = begin; i < end && far_before && far_after && !all; ++i) lost.push_back(i);
    begin = end;
  }
  return lost;
}

void leave_out(TraceRows& rows, const std::vector<std::size_t>& lost) {
  if (lost.empty()) return;
  TraceRows kept = rows;
  kept.times.clear(), kept.positions.clear(), kept.lines.clear();
  for (std::size_t i = 0; i < rows.times.size(); ++i) {
    if (std::ranges::binary_search(lost, i)) continue;
    kept.times.push_back(rows.times[i]);
    kept.positions.push_back(rows.positions[i]);
    kept.lines.push_back(rows.lines[i]);
  }
  rows = std::move(kept);
}

bool are_matrices(const std::vector<TraceRow>& rows, std::size_t first) {
  const std::size_t n = rows.size() - std::min(first, rows.size());
  if (n < 4 || n % 4 != 0) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const TraceCells& cells = rows[first + i].cells;
    double value[4] = {};
    if (cells.size() != 4) return false;
    for (std::size_t k = 0; k < 4; ++k)
      if (!trace_number(cells[k], value[k])) return false;
    if (i % 4 == 3 && (value[0] != 0 || value[1] != 0 || value[2] != 0 || value[3] != 1)) return false;
  }
  return true;
}

}  // namespace forefeel
