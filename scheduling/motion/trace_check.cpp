#include "scheduling/motion/trace_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/common/error.hpp"
#include "geometry/common/quantiles.hpp"
#include "scheduling/motion/device.hpp"
#include "scheduling/motion/trace_file.hpp"

namespace forefeel {

namespace {

void push(TraceRows& out, double t, const Vec3& x, std::size_t line) {
  out.times.push_back(t);
  out.positions.push_back(x);
  out.lines.push_back(line);
}

TraceRows without_samples(const TraceRows& rows) {
  TraceRows out;
  out.missing = rows.missing;
  out.ignored = rows.ignored;
  out.lost = rows.lost;
  out.lost_left_out = rows.lost_left_out;
  out.orientation = rows.orientation;
  return out;
}

TraceCheck::Times times_of(const TraceRows& rows) {
  TraceCheck::Times out;
  std::vector<double> steps;
  double last = rows.times.front();
  for (std::size_t i = 1; i < rows.times.size(); ++i) {
    const double step = rows.times[i] - last;
    if (step > 0) {
      steps.push_back(step);
      last = rows.times[i];
    } else {
      ++(step < 0 ? out.backward : out.repeated);
    }
  }
  if (steps.empty()) return out;
  const double usual = median(steps);
  out.rate = 1 / usual;
  for (const double step : steps) {
    if (!(step > 3 * usual)) continue;
    ++out.gaps;
    out.longest_gap = std::max(out.longest_gap, step);
  }
  return out;
}

TraceCheck::Speed speed_of(const TraceRows& rows) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < rows.times.size(); ++i)
    speeds.push_back((rows.positions[i] - rows.positions[i - 1]).norm() /
                     (rows.times[i] - rows.times[i - 1]));
  if (speeds.empty()) return {};
  std::ranges::sort(speeds);
  const auto at = [&](double share) { return quantile(speeds, share, QuantileRule::inverted_cdf); };
  return {.p50 = at(0.5), .p95 = at(0.95), .p99 = at(0.99), .max = speeds.back()};
}

TraceCheck::Rests rests_of(const TraceRows& rows) {
  TraceCheck::Rests out;
  double resting = 0;
  for (std::size_t begin = 0; begin < rows.times.size();) {
    std::size_t end = begin;
    while (end + 1 < rows.times.size() &&
           (rows.positions[end + 1] - rows.positions[begin]).norm() <= rest_radius)
      ++end;
    const double length = rows.times[end] - rows.times[begin];
    if (length >= rest_seconds) {
      ++out.count;
      resting += length;
      if (length > out.longest) {
        out.longest = length;
        out.longest_from = rows.times[begin];
      }
    }
    begin = length >= rest_seconds ? end + 1 : begin + 1;
  }
  if (rows.times.back() > 0) out.share = resting / rows.times.back();
  return out;
}

}  // namespace

TraceCheck check_trace(const TraceRows& rows, const std::optional<Box>& space) {
  const TraceRows grown = growing(rows);
  TraceCheck check;
  check.rows = rows.times.size();
  check.seconds = grown.times.back();
  check.times = times_of(rows);
  check.speed = speed_of(grown);
  check.box = {rows.positions.front(), rows.positions.front()};
  for (const Vec3& x : rows.positions) {
    check.box.low = check.box.low.cwiseMin(x);
    check.box.high = check.box.high.cwiseMax(x);
  }
  check.start = rows.positions.front().norm();
  check.rests = rests_of(grown);
  if (!space) return check;
  std::size_t outside = 0;
  for (std::size_t i = 0; i < grown.times.size(); ++i) {
    if (space->contains(grown.positions[i])) continue;
    if (outside++ == 0) check.outside_from = grown.times[i];
  }
  check.outside = static_cast<double>(outside) / static_cast<double>(grown.times.size());
  return check;
}

std::vector<std::string> trace_warnings(const TraceCheck& check) {
  std::vector<std::string> lines;
  if (check.starts_pressed_in())
    lines.push_back(
        fmt::format("starts away from rest: its first position is {:.3g} mm from it (forefeel trace "
                    "--to-contact shifts it)",
                    1e3 * check.start));
  if (check.outside.value_or(0) > outside_much)
    lines.push_back(fmt::format("leaves the box of states: {:.3g} % of it is outside, from {:.3g} s on",
                                100 * *check.outside, *check.outside_from));
  if (check.times.longest_gap > long_gap)
    lines.push_back(fmt::format("has {} gaps in time, the longest {:.3g} s: the motion is interpolated there",
                                check.times.gaps, check.times.longest_gap));
  if (check.rests.count > 0)
    lines.push_back(fmt::format("rests for {:.3g} % of its time, longest for {:.3g} s from {:.3g} s on",
                                100 * check.rests.share, check.rests.longest, check.rests.longest_from));
  return lines;
}

std::vector<std::string> trace_notes(const TraceRows& rows) {
  std::vector<std::string> lines;
  if (rows.missing > 0)
    lines.push_back(fmt::format("{} rows without a position are left out, the motion is interpolated there",
                                rows.missing));
  if (rows.lost > 0)
    lines.push_back(
        rows.lost_left_out
            ? fmt::format(
                  "{} rows at 0, 0, 0 far from their neighbours are taken as lost samples and left out",
                  rows.lost)
            : fmt::format(
                  "{} rows at 0, 0, 0 lie far from their neighbours, as samples do that a tracker lost "
                  "(with columns=t/x/y/z they are left out)",
                  rows.lost));
  if (rows.times_unused) lines.push_back("its column of times is not used: the rate gives the times");
  if (rows.orientation)
    lines.push_back(
        fmt::format("the recorded orientation is not used: the HIP is a point ({} columns are "
                    "not read)",
                    rows.ignored));
  return lines;
}

TraceRows growing(const TraceRows& rows) {
  TraceRows out = without_samples(rows);
  for (std::size_t i = 0; i < rows.times.size(); ++i)
    if (out.times.empty() || rows.times[i] > out.times.back())
      push(out, rows.times[i], rows.positions[i], rows.lines[i]);
  return out;
}

TraceRows window(const TraceRows& rows, double from, double to) {
  TraceRows out = without_samples(rows);
  double begin = 0;
  for (std::size_t i = 0; i < rows.times.size(); ++i) {
    if (rows.times[i] < from || rows.times[i] > to) continue;
    if (out.times.empty()) begin = rows.times[i];
    push(out, rows.times[i] - begin, rows.positions[i], rows.lines[i]);
  }
  if (out.times.empty())
    throw InputError(
        "window", fmt::format("has no rows from {:g} s to {:g} s, expected some within 0 to {:g} s", from, to,
                              rows.times.back()));
  return out;
}

TraceRows resampled(const TraceRows& rows, double rate) {
  TraceRows out = without_samples(rows);
  const auto motion = make_trace_device(Trace{rows.times, rows.positions});
  const auto last = static_cast<std::size_t>(std::floor(rows.times.back() * rate + 1e-9));
  for (std::size_t k = 0; k <= last; ++k) {
    const double t = static_cast<double>(k) / rate;
    push(out, t, motion->position(t, Vec3::Zero()), 0);
  }
  return out;
}

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
