#pragma once
// Measurement and comparison of two loops that ran at the same time (bench_loop.cpp).

#include <cstddef>
#include <span>
#include <vector>

#include "scheduling/common/records.hpp"
#include "scheduling/study/statistics.hpp"

namespace forefeel {

// Timing of a loop's frames. A frame is missed if it was skipped (NaN), or if its cost and lateness together exceed its
// length.
struct LoopTimes {
  std::size_t frames = 0, missed = 0;
  std::vector<double> cost, lateness;          // of the frames that were not skipped [us]
  std::vector<std::vector<double>> by_second;  // missed frames in each whole second of each run

  // Adds a run; frame: length of a frame [s].
  void add(std::span<const FrameTiming> run, double frame);
};

// The first `frames` frames of a session's records, by number; NaN where a frame was skipped.
std::vector<FrameTiming> timing_by_frame(std::span<const FrameRecord> records, double frame,
                                         std::size_t frames);

// Missed frames of one loop less those of the other, per 1000 frames. The interval is a bootstrap of 95 % over blocks
// of a second, in which both loops had the same load.
ConfidenceInterval missed_difference(const LoopTimes& ours, const LoopTimes& bare, double frame);

// Memory of this process that is resident now [bytes]; NaN if the system does not report it.
double resident_memory();

// Memory of the process in the course of a run.
struct MemoryCourse {
  std::vector<double> t, bytes;  // [s], [bytes]
  double start() const;          // after the first tenth of the run; NaN without samples [bytes]
  double end() const;
  double growth() const;  // slope of a straight line through the second half [bytes/s]
};

}  // namespace forefeel
