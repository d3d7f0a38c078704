#include "apps/study/study_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "apps/picture/figure.hpp"
#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel {

namespace {

// A name for ids and files: letters, digits and '-'.
std::string as_name(const std::string& text) {
  std::string name;
  for (const char c : text) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  return name;
}

// The least and largest value added, with a margin, limited to the possible range of the metric.
class Range {
 public:
  void add(double value) {
    if (!std::isfinite(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  std::pair<double, double> with_margin(const StudyMetric& metric) const {
    if (metric.ratio) return {low_ / 1.15, high_ * 1.15};
    const double margin = std::max(0.08 * (high_ - low_), 1e-3 * std::max(1.0, std::abs(high_)));
    std::pair<double, double> range{low_ - margin, high_ + margin};
    // The edge stands a little outside, so that a point on it is drawn whole.
    if (metric.share) range = {std::max(range.first, -1.0), std::min(range.second, metric.scale + 1)};
    return range;
  }

 private:
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

std::string interval_row(const StudyMetric& metric, double y, double mean, const ConfidenceInterval& interval,
                         const std::pair<double, double>& range) {
  if (!says_something(metric, interval)) return "";
  return fmt::format("{} {} {} {}\n", mean, y, std::max(in_unit(metric, interval.low), range.first),
                     std::min(in_unit(metric, interval.high), range.second));
}

std::optional<std::vector<double>> numeric(const StudyAxis& axis) {
  std::vector<double> numbers;
  for (const StudyValue& value : axis.values) {
    double number = 0;
    const auto [end, error] =
        std::from_chars(value.text.data(), value.text.data() + value.text.size(), number);
    if (error != std::errc{} || end != value.text.data() + value.text.size()) return {};
    numbers.push_back(number);
  }
  return numbers;
}

// Points of one value of the first axis: x, mean, interval.
std::string level_points(const Study& study, const std::vector<StudyCellResult>& cells, std::size_t axis,
                         const std::vector<double>& x, std::size_t level, Range& seen) {
  const StudyMetric metric = primary_metric(study);
  std::string lines;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const LevelRanking ranking = ranking_of(study, cells, 0, metric, {{axis, v}});
    for (const Ranked& r : ranking.ranked) {
      if (r.level != level) continue;
      const double mean = in_unit(metric, r.value.student.mean);
      const auto at = [&](double value) {
        return says_something(metric, r.value.bootstrap) ? in_unit(metric, value) : mean;
      };
      for (const double value : {mean, at(r.value.bootstrap.low), at(r.value.bootstrap.high)})
        seen.add(value);
      lines +=
          fmt::format("{} {} {} {}\n", x[v], mean, at(r.value.bootstrap.low), at(r.value.bootstrap.high));
    }
  }
  return lines;
}

const char* label_of(Standing standing) {
  return standing == Standing::bound ? " (bound)" : standing == Standing::placebo ? " (placebo)" : "";
}

}  // namespace

std::string name_of(const StudyAxis& axis, std::size_t level) {
  return axis.values[level].text + label_of(standing_of(axis, level));
}

double in_unit(const StudyMetric& metric, double value) {
  return metric.scale * (metric.ratio ? std::exp(value) : value);
}

bool says_something(const StudyMetric& metric, const ConfidenceInterval& interval) {
  if (!std::isfinite(interval.low) || !std::isfinite(interval.high) || !(interval.high > interval.low))
    return false;
  const double width = interval.high - interval.low;
  return metric.share ? width < 0.9 : !metric.ratio || width < std::log(1000.0);
}

std::optional<Figure> ranking_figure(const Study& study, const AxisRanking& entry, const Palette& palette) {
  const auto& ranked = entry.ranking.ranked;
  const StudyMetric& metric = entry.metric;
  if (ranked.empty()) return {};
  Range seen;
  for (const Ranked& r : ranked) {
    seen.add(in_unit(metric, r.value.student.mean));
    if (!says_something(metric, r.value.bootstrap)) continue;
    seen.add(in_unit(metric, r.value.bootstrap.low));
    seen.add(in_unit(metric, r.value.bootstrap.high));
  }
  const auto range = seen.with_margin(metric);
  std::string means, thick, thin, tics;
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const double mean = in_unit(metric, ranked[i].value.student.mean),
                 y = static_cast<double>(ranked.size() - i);
    means += fmt::format("{} {}\n", mean, y);
    thick += interval_row(metric, y, mean, ranked[i].value.bootstrap, range);
    thin += interval_row(metric, y, mean, ranked[i].value.student, range);
    tics += fmt::format("{}'{}' {}", i > 0 ? ", " : "",
                        plain_text(name_of(study.axes[entry.axis], ranked[i].level)), y);
  }
  std::string script = data_block("means", means) + data_block("thick", thick) + data_block("thin", thin);
  script += fmt::format(
      "set yrange [0.4:{}]\nset ytics ({}) noenhanced nomirror\nset xtics nomirror out\nset border 3 lc rgb "
      "'#8a8a8a'\nset grid x lc rgb '#e4e1da'\nset xlabel '{}' noenhanced\nunset key\n{}set xrange [{}:{}]\n",
      static_cast<double>(ranked.size()) + 0.6, tics, plain_text(metric.title),
      metric.ratio ? "set logscale x\n" : "", range.first, range.second);
  script += fmt::format(
      "plot $thin using 1:2:3:4 with xerrorbars pt 0 lw 1.2 lc rgb '#8a8a8a', $thick using 1:2:3:4 with "
      "xerrorbars "
      "pt 0 lw 2.5 lc rgb '{0}', $means using 1:2 with points pt 7 ps 0.9 lc rgb '{0}'\n",
      colour_of(palette, 0));
  return Figure{
      .name = fmt::format("ranking-{}-{}", as_name(study.axes[entry.axis].column), entry.axis),
      .caption = std::string("Mean over motions and seeds; thick: bootstrap interval, thin: Student "
                             "interval over motions") +
                 (metric.share ? " on the logit scale" : "") +
                 ", both 95 %. Intervals that say nothing (fewer than four motions, or as wide as the scale) "
                 "are left out; an end at the frame lies beyond it.",
      .width = 960,
      .height = std::clamp(110 + 34 * static_cast<int>(ranked.size()), 170, 900),
      .script = script};
}

std::optional<Figure> ranks_figure(const Study& study, const AxisRanking& entry, const Palette& palette) {
  const double critical = critical_difference(entry);
  if (!std::isfinite(critical)) return {};
  std::vector<const Ranked*> compete;
  for (const Ranked& r : entry.ranking.ranked)
    if (std::isfinite(r.mean_rank)) compete.push_back(&r);
  std::ranges::stable_sort(compete, {}, &Ranked::mean_rank);
  std::string ranks, tics;
  for (std::size_t i = 0; i < compete.size(); ++i) {
    const double y = static_cast<double>(compete.size() - i), x = compete[i]->mean_rank;
    ranks += fmt::format("{} {} {} {}\n", x, y, x - critical / 2, x + critical / 2);
    tics += fmt::format("{}'{}' {}", i > 0 ? ", " : "",
                        plain_text(name_of(study.axes[entry.axis], compete[i]->level)), y);
  }
  std::string script = data_block("ranks", ranks);
  script += fmt::format(
      "set yrange [0.4:{}]\nset ytics ({}) noenhanced nomirror\nset xtics nomirror out\nset border 3 lc rgb "
      "'#8a8a8a'\nset grid x lc rgb '#e4e1da'\nset xlabel 'mean rank over motions'\nunset key\nplot $ranks "
      "using "
      "1:2:3:4 with xerrorbars pt 7 ps 0.9 lw 2.5 lc rgb '{}'\n",
      static_cast<double>(compete.size()) + 0.6, tics, colour_of(palette, 0));
  return Figure{.name = fmt::format("ranks-{}-{}", as_name(study.axes[entry.axis].column), entry.axis),
                .caption = fmt::format(
                    "Mean rank by {} over the motions, 1: best. Bars: half the critical difference of "
                    "Nemenyi, {:.3g} ranks; two values whose bars do not overlap differ (5 %).",
                    entry.metric.title, critical),
                .width = 960,
                .height = std::clamp(110 + 34 * static_cast<int>(compete.size()), 170, 900),
                .script = script};
}

std::optional<Figure> curves_figure(const Study& study, const std::vector<StudyCellResult>& cells,
                                    std::size_t axis, const Palette& palette) {
  const std::optional<std::vector<double>> x = numeric(study.axes[axis]);
  if (!x || x->size() < 2) return {};
  const StudyMetric metric = primary_metric(study);
  std::string script, plot;
  Range seen;
  const bool positive = std::ranges::all_of(*x, [](double v) { return v > 0; });
  const auto [least, most] = std::ranges::minmax(*x);
  const std::vector<std::size_t> levels = ranked_levels(study, cells, 0);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const std::size_t level = levels[k];
    // Side by side: equal values of two levels would hide each other.
    const double aside = std::min(0.012, 0.1 / static_cast<double>(levels.size())) *
                         (static_cast<double>(k) - 0.5 * static_cast<double>(levels.size() - 1));
    std::vector<double> beside = *x;
    for (double& v : beside)
      v = positive ? v * std::exp(aside * std::log(most / least)) : v + aside * (most - least);
    script +=
        data_block(fmt::format("level{}", level), level_points(study, cells, axis, beside, level, seen));
    plot += fmt::format(
        "{}$level{} using 1:2:3:4 with yerrorbars pt 0 lc rgb '{}' notitle, $level{} using 1:2 with "
        "linespoints pt 7 ps 0.6 lw 2 lc rgb '{}' title '{}' noenhanced",
        plot.empty() ? "plot " : ", ", level, colour_of(palette, level), level, colour_of(palette, level),
        plain_text(name_of(study.axes.front(), level)));
  }
  const double margin = 0.05 * (most - least), widened = 1 + 0.05 * std::log(most / least);
  std::string tics;
  for (const double v : *x) tics += fmt::format("{}'{}' {}", tics.empty() ? "" : ", ", v, v);
  const auto range = seen.with_margin(metric);
  if (!(range.second > range.first)) return {};
  script += fmt::format(
      "set key outside right top\nset border 3 lc rgb '#8a8a8a'\nset tics nomirror out\nset grid lc rgb "
      "'#e4e1da'\nset xrange [{}:{}]\nset xtics ({})\nset yrange [{}:{}]\nset xlabel '{}' noenhanced\nset "
      "ylabel '{}' noenhanced\n{}{}{}\n",
      positive ? least / widened : least - margin, positive ? most * widened : most + margin, tics,
      range.first, range.second, plain_text(study.axes[axis].column), plain_text(metric.title),
      positive ? "set logscale x\n" : "", metric.ratio ? "set logscale y\n" : "", plot);
  return Figure{
      .name = "over-" + as_name(study.axes[axis].column),
      .caption = "Mean over motions and seeds with bootstrap intervals; side by side at each value.",
      .width = 960,
      .height = 420,
      .script = script};
}

std::vector<Figure> study_figures(const Study& study, const std::vector<StudyCellResult>& cells,
                                  const std::vector<AxisRanking>& ranked, const Palette& palette) {
  std::vector<Figure> figures;
  const auto take = [&](std::optional<Figure> figure) {
    if (figure) figures.push_back(*std::move(figure));
  };
  for (const AxisRanking& entry : ranked) {
    take(ranking_figure(study, entry, palette));
    take(ranks_figure(study, entry, palette));
  }
  for (std::size_t axis = 1; axis < study.axes.size(); ++axis)
    take(curves_figure(study, cells, axis, palette));
  return figures;
}

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
