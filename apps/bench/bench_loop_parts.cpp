#include "apps/bench/bench_loop_parts.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace forefeel {

void LoopTimes::add(std::span<const FrameTiming> run, double frame) {
  const auto per_second = static_cast<std::size_t>(std::max(1LL, std::llround(1 / frame)));
  std::vector<double> seconds(run.size() / per_second, 0.0);
  for (std::size_t k = 0; k < run.size(); ++k) {
    const double took = run[k].cost_us + run[k].lateness_us;
    const bool skipped = std::isnan(took), late = skipped || took > frame * 1e6;
    if (!skipped) {
      cost.push_back(run[k].cost_us);
      lateness.push_back(run[k].lateness_us);
    }
    missed += late ? 1 : 0;
    if (late && k / per_second < seconds.size()) seconds[k / per_second] += 1;
  }
  frames += run.size();
  by_second.push_back(std::move(seconds));
}

std::vector<FrameTiming> timing_by_frame(std::span<const FrameRecord> records, double frame,
                                         std::size_t frames) {
  std::vector<FrameTiming> timing(frames);
  for (const FrameRecord& record : records) {
    const auto k = static_cast<std::size_t>(std::max(0LL, std::llround(record.t / frame)));
    if (k < frames) timing[k] = record.timing;
  }
  return timing;
}

ConfidenceInterval missed_difference(const LoopTimes& ours, const LoopTimes& bare, double frame) {
  GroupedValues differences;  // each second is a group of its own
  for (std::size_t run = 0; run < std::min(ours.by_second.size(), bare.by_second.size()); ++run)
    for (std::size_t i = 0; i < std::min(ours.by_second[run].size(), bare.by_second[run].size()); ++i)
      differences.push_back({1000 * frame * (ours.by_second[run][i] - bare.by_second[run][i])});
  return bootstrap_interval(differences);
}

double resident_memory() {
  std::ifstream in("/proc/self/statm");
  double mapped = 0, resident = 0;
  return in >> mapped >> resident ? resident * static_cast<double>(sysconf(_SC_PAGESIZE)) : unknown;
}

double MemoryCourse::start() const {
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] >= 0.1 * t.back()) return bytes[i];
  return unknown;
}

double MemoryCourse::end() const {
  return bytes.empty() ? unknown : bytes.back();
}

double MemoryCourse::growth() const {
  double n = 0, mean_t = 0, mean_b = 0, tt = 0, tb = 0;
  const auto begin = t.size() / 2;
  for (std::size_t i = begin; i < t.size(); ++i) n += 1, mean_t += t[i], mean_b += bytes[i];
  if (n < 2) return unknown;
  mean_t /= n, mean_b /= n;
  for (std::size_t i = begin; i < t.size(); ++i) {
    tt += (t[i] - mean_t) * (t[i] - mean_t);
    tb += (t[i] - mean_t) * (bytes[i] - mean_b);
  }
  return tt > 0 ? tb / tt : unknown;
}

}  // namespace forefeel
