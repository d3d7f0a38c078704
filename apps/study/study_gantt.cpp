#include "apps/study/study_gantt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel {
namespace {

constexpr double strip = -1.2;  // row of the HIP's label, below the workers

struct Bars {
  std::string used, unused, preempted;  // x y xlow xhigh ylow yhigh colour
};

long rgb(Label label) {
  return std::stol(std::string(colour(label).substr(1)), nullptr, 16);
}

Bars bars_of(const SessionResult& result, double seconds) {
  Bars bars;
  for (const DispatchRecord& job : result.dispatch) {
    if (job.worker < 0 || !std::isfinite(job.started)) continue;
    const double end = std::min(std::isfinite(job.finished) ? job.finished : seconds, seconds);
    const bool preempted = job.status == DispatchStatus::preempted, used = std::isfinite(job.first_used);
    const double half = preempted ? 0.1 : used || job.status == DispatchStatus::running ? 0.4 : 0.22;
    std::string& group = preempted ? bars.preempted : used ? bars.used : bars.unused;
    group += fmt::format("{0:.6g} {1} {0:.6g} {2:.6g} {3} {4} {5}\n", job.started, job.worker, end,
                         job.worker - half, job.worker + half, rgb(job.label));
  }
  return bars;
}

std::string hip_strip(const SessionResult& result) {
  std::string lines;
  for (std::size_t begin = 0; begin < result.frames.size();) {
    std::size_t end = begin;
    while (end < result.frames.size() && result.frames[end].label == result.frames[begin].label) ++end;
    const double from = result.frames[begin].t,
                 to = end < result.frames.size() ? result.frames[end].t : result.frames.back().t;
    lines += fmt::format("{0:.6g} {1} {0:.6g} {2:.6g} {3} {4} {5}\n", from, strip, to, strip - 0.38,
                         strip + 0.38, rgb(result.frames[begin].label));
    begin = end;
  }
  return lines;
}

// Above the bars: the labels by colour, then what the heights mean.
std::string legend() {
  std::string keys;
  for (const Label label : all_labels)
    keys += fmt::format(", keyentry with boxes fs solid 1 border lc rgb '#6b6b6b' fc rgb '{}' title '{}'",
                        colour(label), name(label));
  for (const auto& [size, meaning] :
       {std::pair(1.8, "high: used by a model"), {1.1, "half: never used"}, {0.5, "thin: cancelled"}})
    keys += fmt::format(", keyentry with points pt 5 ps {} lc rgb '#8a8a8a' title '{}'", size, meaning);
  return keys;
}

}  // namespace

Figure gantt_figure(const SessionResult& result, double seconds, int workers) {
  const Bars bars = bars_of(result, seconds);
  Figure figure{.name = "gantt",
                .caption =
                    "One row a worker, one bar a solve, coloured by the label of its region when it was "
                    "dispatched. Half height: no model ever took the state; thin: cancelled. Lowest row: "
                    "label at the HIP.",
                .width = 1100,
                .height = std::clamp(140 + 26 * workers, 200, 1400),
                .script = {}};
  std::string& s = figure.script;
  s += data_block("used", bars.used) + data_block("unused", bars.unused) +
       data_block("preempted", bars.preempted) + data_block("hip", hip_strip(result));
  s += fmt::format(
      "set xrange [0:{}]\nset yrange [{}:{}]\nset xlabel 'time [s]'\nset ylabel 'worker'\nset tics out "
      "nomirror\n"
      "set border 3 lc rgb '#8a8a8a'\nset style fill solid 1 border lc rgb '#6b6b6b'\n",
      seconds, strip - 0.8, workers - 0.4);
  s += fmt::format("set ytics ('HIP' {}", strip);
  const int every = std::max(1, workers / 16);
  for (int w = 0; w < workers; w += every) s += fmt::format(", '{}' {}", w + 1, w);
  s += ")\nset key outside top left horizontal samplen 1.5 textcolor rgb '#3a3a3a'\nplot ";
  for (const char* group : {"unused", "used", "preempted", "hip"})
    s += fmt::format("{}${} using 1:2:3:4:5:6:7 with boxxyerror lc rgb variable notitle",
                     group == std::string_view("unused") ? "" : ", ", group);
  s += legend() + "\n";
  return figure;
}

}  // namespace forefeel
