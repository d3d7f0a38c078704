#pragma once
// Checks a recorded motion before a session uses it: times, speeds, extent, rests. Also cuts a motion to a window and
// resamples it.
//
// Speeds are |x_{i+1} - x_i| / (t_{i+1} - t_i). A gap is a step in time longer than three times the median
// one. A rest is a run of rows that stay within rest_radius of its first row for at least rest_seconds. Rows whose time
// repeats or goes back are ignored when steps are computed.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "geometry/common/types.hpp"
#include "scheduling/motion/trace.hpp"
#include "scheduling/motion/trace_cells.hpp"
#include "scheduling/motion/trace_file.hpp"

namespace forefeel {

constexpr double rest_radius = 1e-4;      // [m]
constexpr double rest_seconds = 1;        // [s]
constexpr double pressed_in_from = 5e-4;  // a motion that starts farther from rest starts pressed in [m]
constexpr double long_gap = 0.1;          // above it trace_warnings() mentions gaps [s]
constexpr double outside_much =
    0.05;  // share of rows outside the box above which trace_warnings() mentions it

struct TraceCheck {
  struct Times {
    std::size_t repeated = 0, backward = 0;  // rows
    std::size_t gaps = 0;
    double longest_gap = 0;  // [s]; 0: no gap
    double rate = 0;         // 1 / median step [Hz]; 0 with one row
  };
  struct Speed {
    double p50 = 0, p95 = 0, p99 = 0, max = 0;  // [m/s]
  };
  struct Rests {
    std::size_t count = 0;
    double share = 0;                      // of the duration
    double longest = 0, longest_from = 0;  // [s]
  };
  std::size_t rows = 0;
  double seconds = 0;  // duration [s]
  Times times = {};
  Speed speed = {};
  Box box = {};
  double start = 0;  // distance of the first row from rest [m]
  Rests rests = {};
  // Share of the rows outside the scene's box, and when the first one comes [s]; unset: no scene.
  std::optional<double> outside = {}, outside_from = {};
  bool starts_pressed_in() const { return start > pressed_in_from; }
};

// rows: at least one. space: the scene's box of states.
TraceCheck check_trace(const TraceRows& rows, const std::optional<Box>& space);
// Warnings for a session with this motion: it starts away from rest, leaves the box, has long gaps, or rests. One line
// each; empty if there are none.
std::vector<std::string> trace_warnings(const TraceCheck& check);
// Notes on rows left out and columns not read: "orientation is not used …". Empty if there are none.
std::vector<std::string> trace_notes(const TraceRows& rows);

// The first row of each time; rows that go back are left out.
TraceRows growing(const TraceRows& rows);
// Rows from `from` to `to` [s], the first of them at time 0. InputError if there is none.
TraceRows window(const TraceRows& rows, double from, double to);
// Samples of the motion `rate` times a second, from its first row to its last (trace.hpp interpolates).
TraceRows resampled(const TraceRows& rows, double rate);

// Flaws of recorded motions that are valid numbers.
//
// Lost samples: many trackers write 0, 0, 0 while they do not see their tool. A run of rows at exactly zero
// counts as lost if every row beside it lies farther than lost_jump from zero, and farther than lost_steps median
// steps of the other rows. A motion that passes through zero, or rests there, keeps its rows.
//
// Matrices: a pose written as a 4 x 4 matrix takes four lines, the last of them 0 0 0 1. Such lines are not
// samples of a motion.

constexpr double lost_jump = 0.01;  // [m]
constexpr double lost_steps = 20;

// Indices of the lost rows, ascending.
std::vector<std::size_t> lost_rows(const TraceRows& rows);
void leave_out(TraceRows& rows, const std::vector<std::size_t>& lost);

// True if all rows from `first` on have four numbers and every fourth of these rows is 0 0 0 1.
bool are_matrices(const std::vector<TraceRow>& rows, std::size_t first);

}  // namespace forefeel
