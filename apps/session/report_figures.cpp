#include "apps/session/report_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/picture/palette.hpp"
#include "apps/picture/plot.hpp"

namespace forefeel {
namespace {

using Frames = std::span<const FrameRecord>;

template <class Value>
std::vector<double> values_of(Frames frames, Value value) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameRecord& frame : frames) values.push_back(value(frame));
  return values;
}
std::vector<double> values_of(Frames frames, double Judgement::*member) {
  return values_of(frames, [member](const FrameRecord& f) { return f.judged.*member; });
}
std::vector<double> values_of(Frames frames, double FrameTiming::*member) {
  return values_of(frames, [member](const FrameRecord& f) { return f.timing.*member; });
}
template <class Force>
std::vector<double> norms(Frames frames, Force force) {
  return values_of(frames, [force](const FrameRecord& f) {
    const Vec3& v = force(f);
    return std::hypot(v[0], v[1], v[2]);
  });
}

std::string scatter(const std::vector<double>& x, const std::vector<double>& y) {
  std::string lines;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(y[i])) lines += fmt::format("{:.6g} {:.6g}\n", x[i], y[i]);
  return lines;
}

double largest(const std::vector<double>& values, double at_least) {
  double most = at_least;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, value);
  return most;
}

// Runs of one label as boxes "x_low x_high" per label.
std::string strip_blocks(Frames frames, const std::vector<double>& t) {
  ByLabel<std::string> boxes;
  for (std::size_t begin = 0, end = 0; begin < t.size(); begin = end) {
    const Label label = frames[begin].label;
    while (end < t.size() && frames[end].label == label) ++end;
    const double until = end < t.size() ? t[end] : t.back();
    boxes[label] += fmt::format("{:.6g} 0.5 {:.6g} {:.6g} 0 1\n", 0.5 * (t[begin] + until), t[begin], until);
  }
  std::string blocks;
  for (std::size_t i = 0; i < all_labels.size(); ++i)
    blocks += data_block(fmt::format("strip_{}", name(all_labels[i])), boxes[i]);
  return blocks;
}

// Forces over time: the data blocks and the plot.
struct Curves {
  std::vector<double> t, rendered, sent, undamped, reference;
  double limit = unknown;  // [N]
  double end = 1e-3;       // [s]
  std::string felt;        // time and force of steps that a hand feels

  Curves(const SessionResult& result, const RunView& view) : Curves(Frames(result.frames), view.force_limit) {
    for (const FeltStep& step : felt_steps(result.frames, view.felt, result.loop.ending_frames)) {
      const auto at = static_cast<std::size_t>(std::ranges::lower_bound(t, step.t) - t.begin());
      felt += fmt::format("{:.6g} {:.6g}\n", step.t, sent[at]);
    }
  }
  Curves(Frames frames, double force_limit)
      : t(values_of(frames, [](const FrameRecord& f) { return f.t; })),
        rendered(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.force; })),
        sent(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.sent; })),
        undamped(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.undamped; })),
        reference(norms(frames, [](const FrameRecord& f) -> const Vec3& { return f.judged.reference; })),
        limit(force_limit) {
    if (t.size() > 1) end = t.back() + t[1] - t[0];
  }
  std::pair<std::size_t, std::size_t> rows(double from, double until) const {
    return {static_cast<std::size_t>(std::ranges::lower_bound(t, from) - t.begin()),
            static_cast<std::size_t>(std::ranges::upper_bound(t, until) - t.begin())};
  }
  std::string blocks(double from, double until, std::size_t bins) const {
    const auto [begin, last] = rows(from, until);
    const auto part = [&, first = begin, n = last - begin](const std::vector<double>& values) {
      return std::span(values).subspan(first, n);
    };
    return data_block("rendered", thinned_curve(part(t), part(rendered), bins)) +
           data_block("sent", thinned_curve(part(t), part(sent), bins)) +
           data_block("undamped", thinned_curve(part(t), part(undamped), bins)) +
           data_block("reference", scatter(t, reference)) +
           data_block("felt", felt.empty() ? "NaN NaN\n" : felt);
  }
  std::string plot(double from, double until) const {
    const auto [begin, last] = rows(from, until);
    double top = 0.1;
    for (std::size_t i = begin; i < last; ++i) top = std::max(top, rendered[i]);
    return fmt::format(
               "set key top right horizontal samplen 2 textcolor rgb '#3a3a3a'\nset yrange [0:{:.4g}]\nset "
               "ylabel 'force [N]' offset 1\n",
               1.2 * top) +
           limit_mark(1.2 * top) +
           fmt::format(
               "plot $reference with points pt 7 ps 0.55 lc rgb '{}' title 'reference', $undamped with lines "
               "lw 1 lc rgb '{}' title 'newest model, undamped', "
               "$rendered with lines lw 1.3 lc rgb '{}' title 'rendered', $sent with lines lw 1 lc rgb '{}' "
               "title 'sent to the device', $felt with points pt 2 ps 0.9 lw 1.6 lc rgb '{}' title 'felt "
               "step'\nunset arrow 1\nunset label 1\n",
               ink("reference_light"), ink("undamped"), ink("rendered"), ink("sent"), ink("limit"));
  }

 private:
  std::string limit_mark(double top) const {
    if (!std::isfinite(limit)) return "";
    if (limit > top)
      return fmt::format(
          "set label 1 'force limit {:.3g} N, above this axis' at graph 0.01, graph 0.85 "
          "textcolor rgb '{}'\n",
          limit, ink("limit"));
    // The legend lies along the top.
    return fmt::format(
        "set arrow 1 from graph 0, first {0} to graph 1, first {0} nohead lw 1 dt 2 lc rgb '{1}' front\n"
        "set label 1 'force limit {2:.3g} N' at graph 0.01, first {0} offset 0,{3} textcolor rgb '{1}' "
        "front\n",
        limit, ink("limit"), limit, limit > 0.75 * top ? -0.6 : 0.6);
  }
};

std::string screen_part(double top, double bottom) {
  return fmt::format("set tmargin at screen {}\nset bmargin at screen {}\n", top, bottom);
}

std::string strip_plot() {
  std::string text;
  for (const Label label : all_labels)
    text +=
        fmt::format("{}$strip_{} using 1:2:3:4:5:6 with boxxyerror fs solid 1 noborder fc rgb '{}' notitle",
                    text.empty() ? "plot " : ", ", name(label), colour(label));
  return text + "\n";
}

// The colours of the strip, in the plot below it.
std::string label_key() {
  std::string keys;
  for (const Label label : all_labels)
    keys += fmt::format(", keyentry with boxes fs solid 1 border lc rgb '#6b6b6b' fc rgb '{}' title '{}'",
                        colour(label), name(label));
  return keys;
}

std::string error_plot() {
  return fmt::format(
      "set key top right horizontal samplen 2 textcolor rgb '#3a3a3a'\nset logscale y\nset format y "
      "'10^{{%T}}'\n"
      "set yrange [1e-6:3]\nset ylabel 'relative error' offset 1\nset arrow from graph 0, first 0.07 to "
      "graph 1, first 0.07 nohead lw 0.8 dt 2 lc rgb '#6a6a6a' back\n"
      "set label '7 %' at graph 0.97, first 0.12 textcolor rgb '#6a6a6a'\n"
      "plot $error with lines lw 1 lc rgb '{}' title 'rendered', $approximation with points pt 7 ps 0.3 lc "
      "rgb '{}' title 'approximation', "
      "$staleness with points pt 7 ps 0.3 lc rgb '{}' title 'staleness', $switch with points pt 7 ps 0.3 lc "
      "rgb '{}' title 'switch'\n",
      ink("rendered"), ink("approximation"), ink("staleness"), ink("switching"));
}

// The round number (1, 2 or 5 times a power of ten) at or above a value.
double round_step(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (value <= factor * power) return factor * power;
  return 10 * power;
}

// ---- deadlines

// Counts in equal steps of log10, with a floor of one tenth of a microsecond.
std::string histogram(const std::vector<double>& values, double& peak) {
  constexpr int per_decade = 12, bins = 6 * per_decade;
  std::array<std::size_t, bins> counts{};
  for (const double value : values)
    if (std::isfinite(value))
      ++counts[static_cast<std::size_t>(std::clamp(
          static_cast<int>(std::floor((std::log10(std::max(value, 0.1)) + 1) * per_decade)), 0, bins - 1))];
  std::string lines;
  for (int i = 0; i < bins; ++i) {
    if (counts[static_cast<std::size_t>(i)] == 0) continue;
    const double low = std::pow(10, static_cast<double>(i) / per_decade - 1),
                 high = std::pow(10, (i + 1.0) / per_decade - 1);
    const auto count = static_cast<double>(counts[static_cast<std::size_t>(i)]);
    peak = std::max(peak, count);
    lines += fmt::format("{:.5g} {} {:.5g} {:.5g} 0.5 {}\n", std::sqrt(low * high), count, low, high, count);
  }
  return lines;
}

}  // namespace

Figure time_figure(const SessionResult& result, const RunView& view) {
  const Frames frames = result.frames;
  const Curves curves(result, view);
  const std::vector<double> states =
      values_of(frames, [](const FrameRecord& f) { return static_cast<double>(f.known); });
  std::string script = curves.blocks(0, curves.end, 1400) + plot_style + "set grid noxtics\n" +
                       strip_blocks(frames, curves.t) +
                       data_block("known", thinned_curve(curves.t, states, 700));
  const std::pair<const char*, double Judgement::*> parts[] = {{"error", &Judgement::error},
                                                               {"approximation", &Judgement::approximation},
                                                               {"switch", &Judgement::switching},
                                                               {"staleness", &Judgement::staleness}};
  for (const auto& [part, member] : parts)
    script += data_block(part, scatter(curves.t, values_of(frames, member)));
  script += fmt::format(
      "set multiplot\nset xrange [0:{}]\nset lmargin at screen 0.075\nset rmargin at screen 0.985\n"
      "set format x ''\n",
      curves.end);
  script += screen_part(0.985, 0.60) + curves.plot(0, curves.end);
  script +=
      screen_part(0.585, 0.555) +
      "unset ylabel\nset yrange [0:1]\nunset ytics\nunset grid\nset border 0\nunset xtics\nunset key\n" +
      strip_plot();
  script += "set border 3\nset xtics nomirror out scale 0.5\nset ytics nomirror autofreq\nset grid ytics\n";
  const double known = largest(states, 1);
  script +=
      screen_part(0.535, 0.385) + fmt::format(
                                      "set yrange [0:{}]\nset ytics {}\nset ylabel 'states known' offset 1\n"
                                      "set key bottom right horizontal samplen 1\n"
                                      "plot $known with lines lw 1.6 lc rgb '{}' notitle{}\nunset key\n",
                                      1.1 * known, round_step(known / 4), ink("rendered"), label_key());
  script += screen_part(0.365, 0.065) +
            "set format x '%g'\nset ytics autofreq\nset xlabel 'time [s]' offset 0,0.6\n" + error_plot();
  return {"time",
          "Force of the body on the hand, label at the hand, number of known states, and the error of the "
          "rendered force with its three parts, if above 1e-6. Rendered: after the switch, before the safety "
          "rules; sent: after them. Reference: tight solves on the reference branch, sampled along the path.",
          960, 820, script + "unset multiplot\n"};
}

bool has_deadlines(Frames frames) {
  return std::ranges::any_of(frames, [](const FrameRecord& f) { return std::isfinite(f.timing.cost_us); });
}

Figure deadline_figure(Frames frames) {
  double peak = 1;
  const std::string cost = histogram(values_of(frames, &FrameTiming::cost_us), peak),
                    late = histogram(values_of(frames, &FrameTiming::lateness_us), peak);
  const std::string script =
      data_block("cost", cost) + data_block("late", late) + plot_style + "set grid noxtics\n" +
      fmt::format(
          "set multiplot layout 1,2 margins 0.075,0.985,0.2,0.88 spacing 0.07,0.1\nset logscale xy\nset "
          "xrange [0.1:1e5]\nset yrange [0.5:{}]\n"
          "set format x '10^{{%T}}'\nset format y '10^{{%T}}'\nset ylabel 'frames'\nset arrow from first "
          "1000, graph 0 to first 1000, graph 1 nohead lw 0.8 dt 2 lc rgb '#6a6a6a'\n"
          "set label 'one frame' at first 1150, graph 0.93 textcolor rgb '#6a6a6a'\n",
          2 * peak) +
      fmt::format(
          "set title 'cost of a frame'\nset xlabel 'time [µs]'\nplot $cost using 1:2:3:4:5:6 with "
          "boxxyerror fs solid 1 noborder fc rgb '{}' notitle\n"
          "unset ylabel\nset title 'lateness of the wake-up'\nplot $late using 1:2:3:4:5:6 with boxxyerror "
          "fs solid 1 noborder fc rgb '{}' notitle\nunset multiplot\n",
          ink("reference"), ink("switching"));
  return {"deadline",
          "Loop at 1 kHz. Left: time to compute a frame. Right: delay with which the system wakes the loop. "
          "All axes are logarithmic.",
          960, 290, script};
}

Figure site_figure(std::span<const FrameRecord> frames, const SurfaceMap& surface) {
  std::string facets, sites;
  for (std::size_t f = 0; f < surface.facets().size(); ++f) {
    const auto [a, b, c] = surface.corners(static_cast<std::int32_t>(f));
    const Vec3 at = 1e3 * (a + b + c) / 3;
    facets += fmt::format("{:.4g} {:.4g} {:.4g}\n", at[0], at[1], at[2]);
  }
  for (const FrameRecord& frame : frames)
    if (std::isfinite(frame.judged.error) && frame.touch.site.exists()) {
      const Vec3 at = 1e3 * frame.touch.site.at;
      sites += fmt::format("{:.4g} {:.4g} {:.4g} {:.4g}\n", at[0], at[1], at[2],
                           std::max(1e-3, 100 * frame.judged.error));
    }
  Figure figure;
  figure.name = "sites";
  figure.caption =
      "Where on the body the hand was (facets in grey, seen along y and along z), by the error of the "
      "rendered force there in %.";
  figure.width = 960, figure.height = 440;
  if (sites.empty()) sites = "NaN NaN NaN NaN\n";
  figure.script = std::string(plot_style) + data_block("body", facets) + data_block("sites", sites) +
                  "set multiplot layout 1,2\nset size ratio -1\nset logscale cb\nset cbrange [0.01:100]\n"
                  "set palette defined (0 '#2166ac', 0.5 '#f7f7f7', 0.62 '#f4a582', 1 '#b2182b')\n"
                  "set xlabel 'x [mm]'\nset ylabel 'z [mm]'\nset key off\n"
                  "plot $body using 1:3 with dots lc rgb '#888888', $sites using 1:3:4 with points pt 7 ps "
                  "0.5 lc palette\n"
                  "set ylabel 'y [mm]'\n"
                  "plot $body using 1:2 with dots lc rgb '#888888', $sites using 1:2:4 with points pt 7 ps "
                  "0.5 lc palette\n"
                  "unset multiplot\n";
  return figure;
}

}  // namespace forefeel
